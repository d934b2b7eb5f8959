"""One run of a user's code, and what it waits for."""

from __future__ import annotations

import sys
from abc import ABCMeta
from collections.abc import Callable, Coroutine, Sequence
from dataclasses import dataclass
from random import Random
from typing import Any, Protocol
from weakref import WeakSet

from greenlet import GreenletExit, getcurrent, greenlet
from rclpy.context import Context
from rclpy.node import Node
from rclpy.task import Future, FutureState, Task
from typing_extensions import override

from bt_mission.ros.virtual_time import VirtualTimeExecutor


class Over(Future):
    """The end of a wait: a future without a lock and without callbacks."""

    @property
    def is_over(self) -> bool:
        """Whether the wait has ended."""
        return self._state is not FutureState.PENDING

    def __init__(self) -> None:
        self._state = FutureState.PENDING
        self._result: Any = None
        self._exception = None
        self._exception_fetched = False

    @override
    def set_result(self, result: Any) -> None:
        """End the wait; the first result counts."""
        if self._state is FutureState.PENDING:
            self._result = result
            self._state = FutureState.FINISHED


class CallWait:
    """The wait of a call.

    Args:
        what: For people, such as ``sleeps``.
        is_timed: Whether time ends it.
        owner: Returns the call that has to do something to end it, if there is only one.
    """

    __slots__ = ("is_timed", "over", "owner", "was_checked", "what")

    def __init__(
        self,
        what: str,
        is_timed: bool = False,  # noqa: FBT001, FBT002 - as an attribute
        owner: Callable[[], Call | None] = lambda: None,
    ) -> None:
        self.what, self.is_timed, self.owner = what, is_timed, owner
        self.over = Over()
        self.was_checked = False
        """Whether nothing that waited when it began waits for its call."""

    def run_out(self) -> None:
        """Note that its time is over."""
        self.over.set_result(False)


@dataclass(eq=False)
class Life:
    """A thread as a program sees it: its number, and its object once that is asked for."""

    ident: int
    thread: Any = None


class Host(Protocol):
    """What runs calls (:class:`bt_mission.programs.host.ProgramHost`)."""

    clock: VirtualTimeExecutor
    is_over: bool
    executors: WeakSet[Any]
    polls: dict[CallWait, Callable[[], bool]]
    goals: Any

    def wait(self, wait: CallWait, timeout_ns: int | None = None) -> bool:
        """Suspend the call whose code runs, for a wait or a time."""

    def take_time(self, call: Call) -> int:
        """Return the present, ns. After some calls at one instant, time moves."""

    def new_life(self) -> Life:
        """Return a new thread."""

    def start(self, call: Call) -> None:
        """Run a call that serves no entity."""

    def leave(self, call: Call, status: int) -> None:
        """End the program of a call, whose code runs, at once."""

    def serve(self, node: Node, executor: Any) -> None:
        """Let an executor serve a node."""

    def unserve(self, node: Node, executor: Any) -> None:
        """Let an executor serve a node no longer."""

    def serve_always(self, node: Node, entity: Any) -> None:
        """Serve an entity also while no thread is free."""

    def serve_as_others(self, entity: Any) -> None:
        """End that."""

    def remark_on_sleep(self, call: Call) -> None:
        """Note that a call sleeps on ROS time in the only thread of its executor."""

    def wake(self, executor: Any) -> None:
        """Note that entities came or went, or that a context was shut down."""

    def create_task(
        self,
        executor: Any,
        callback: Callable[..., Any] | Coroutine[Any, Any, Any],
        args: Sequence[Any],
        kwargs: dict[str, Any],
    ) -> Task:
        """Run a function or a coroutine as a task of an executor."""


class Program:
    """Code of users with its own random numbers, and its own view of rclpy.

    Args:
        name: For people.
        seed: Of its random numbers.
        context: The rclpy context that is the default one for it; None makes one.
    """

    def __init__(self, host: Host, name: str, seed: str, context: Context | None) -> None:
        self.host, self.name, self.context = host, name, context
        self.random = Random(seed)
        self.life = host.new_life()
        self.handlers: dict[int, Any] = {}
        """Its handlers of signals, by number."""
        self.wakeup_file = -1
        """Where the number of a signal is written, such as to a loop of ``asyncio``."""
        self.ends_with_signal = False
        """Whether rclpy shuts its contexts down at a signal."""
        self.was_interrupted = False
        """Whether it has got a signal."""
        self.contexts: list[Context] = []
        """Those that it has initialized."""
        self.executor: Any = None
        """What ``rclpy.spin`` and the like use, once there is one."""

    def serving(self) -> Any:
        """Return the executor of ``rclpy.spin``."""
        return self.executor

    def swap_in(self) -> None:
        """Give its code the view of the process that it has, whenever it continues."""

    def swap_out(self) -> None:
        """Give others theirs."""


class Call(greenlet):
    """One run of a user's code: a callback, a task, a thread.

    Args:
        program: Whose code it is.
        life: The thread that the code believes to be in.
        spin: What serves the callback, and is busy with it until it ends; None for a thread.
        entity: The entity that the callback serves.
        node: Whose it is.
    """

    def __init__(
        self,
        program: Program,
        life: Life,
        spin: Any,
        entity: Any,
        node: Any,
        function: Callable[..., Any],
        *args: Any,
    ) -> None:
        super().__init__()
        self.program, self.life, self.spin = program, life, spin
        self.entity, self.node = entity, node
        self.outcome: Any = None
        self.wait: CallWait | None = None
        self.is_over = False
        self.handler: Callable[[], Any] | None = None
        """Of a signal, to be called where the code waits."""
        self.round_ns = self.rounds = 0
        self.loops_since_ns: int | None = None
        """When it began to loop, while it waits for nothing else."""
        self.number = -1
        """Of the task that it is; a callback has none."""
        self.loop: Any = None
        """The loop of ``asyncio`` that runs in its code, while it waits."""
        self._function, self._args = function, args

    def run(self) -> None:
        """Run the code (greenlet calls this)."""
        self.outcome = self._function(*self._args)

    def waits_for(self, over: Over) -> bool:
        """Return whether it waits, and this is the end of it."""
        return self.wait is not None and self.wait.over is over

    def park(self, wait: CallWait) -> Any:
        """Wait, while virtual time continues. Return the result; called by the code that waits.

        Raises:
            BaseException: The result, if it is an exception.
        """
        if self.is_over or self.program.host.is_over:
            raise GreenletExit
        while True:
            self.wait = wait
            try:
                assert self.parent is not None, "a call is resumed by its host"
                self.parent.switch()
            finally:
                self.wait = None
            if self.handler is None:
                break
            handle, self.handler = self.handler, None
            handle()
            if wait.over.is_over:
                break
        result = wait.over._result
        if isinstance(result, BaseException):
            raise result
        return result


def running_loop(loop: Any) -> Any:
    """Exchange the loop of ``asyncio`` that runs, one for each thread of the system."""
    events: Any = sys.modules.get("asyncio.events")
    former = None if events is None else events._get_running_loop()
    if former is not loop:
        events._set_running_loop(loop)
    return former


def current_call() -> Call | None:
    """Return the call whose code runs; None outside of the code of programs."""
    current = getcurrent()
    return current if type(current) is Call else None


class StandIn(ABCMeta):
    """A class in the place of ``_stands_for``, whose objects it makes where no program runs.

    Its subclasses are ordinary classes.
    """

    def __call__(cls, *args: Any, **kwargs: Any) -> Any:
        """Make an object; outside of the code of programs, one of the original."""
        original = cls.__dict__.get("_stands_for")
        if original is not None and current_call() is None:
            return original(*args, **kwargs)
        return super().__call__(*args, **kwargs)

    def __instancecheck__(cls, instance: Any) -> bool:
        """Return whether it is an object of the class, or of the original."""
        return super().__instancecheck__(instance) or isinstance(
            instance, cls.__dict__.get("_stands_for", ())
        )

    def __subclasscheck__(cls, subclass: type) -> bool:
        """Return whether a class inherits from it, or from the original."""
        return super().__subclasscheck__(subclass) or issubclass(
            subclass, cls.__dict__.get("_stands_for", ())
        )
