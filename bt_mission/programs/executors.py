"""rclpy's executors, as the code of a program sees them.

The stage serves all nodes. An executor of a program says when those that it has may be served:
while it spins, and one of its threads is free.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any

from rclpy import executors
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import Executor, ExternalShutdownException, TimeoutObject
from rclpy.node import Node
from rclpy.task import Future, Task
from typing_extensions import override

from bt_mission.base.stamps import NS
from bt_mission.programs.calls import Call, CallWait, Life, Program, StandIn, current_call

ENDLESS = -1
SPINS = "spins"


class ExecutorSpin:
    """A call that serves an executor, in its own thread or with others.

    Args:
        caller: Who waits; None for the executor of nodes that no program spins.
        left: Callbacks after which it returns; negative for no limit.
    """

    def __init__(self, executor: ProgramExecutor, caller: Call | None, left: int) -> None:
        self.executor, self.caller, self.left = executor, caller, left
        self.wait = CallWait(SPINS)
        self.busy: list[Call] = []

    def begin(self, call: Call) -> None:
        """Note that a callback runs."""
        self.busy.append(call)
        self.executor.blocked.append(call)
        self.left -= 1
        if self.executor.failed:
            self.wait.over.set_result(self.executor.failed.pop(0))
        if self.left == 0 and self.executor.hands_over:
            self.wait.over.set_result(True)

    def end(self, call: Call) -> None:
        """Note that a callback has ended, or awaits something."""
        self.busy.remove(call)
        self.executor.blocked.remove(call)
        self.executor.free_life(call.life)
        if self.left == 0 and not self.busy:
            self.wait.over.set_result(True)

    def fail(self, error: BaseException) -> bool:
        """Raise the exception of a callback where the program spins; False if nothing spins.

        As in rclpy, that of another thread is raised with the next callback, and ``SystemExit``
        ends nothing there.
        """
        if self.caller is None:
            return False
        if self.executor.hands_over:
            if isinstance(error, Exception):
                self.executor.failed.append(error)
            return True
        self.wait.over.set_result(error)
        return True


class _OwnSpin(ExecutorSpin):
    """Serves the nodes that nothing spins; a node that spins to wait counts what it serves."""

    @override
    def end(self, call: Call) -> None:
        super().end(call)
        self.executor.count(call)


class ProgramExecutor(Executor):
    """The threads of an executor, each of which runs one callback at a time."""

    hands_over = False
    """Whether callbacks run in other threads than that which spins."""

    def __init__(self, *, context: Context | None = None, program: Any = None) -> None:
        call = current_call()
        if program is None and call is None:
            raise RuntimeError("an executor of a program is made by its code")
        self.program: Program = program or call.program
        self.host = self.program.host
        self._ordered: list[Node] = []
        self._spins: list[ExecutorSpin] = []
        self._lives: list[Life] = []
        self.blocked: list[Call] = []
        """The callbacks that hold its threads, also where it spins no more."""
        self.waiting: dict[int, Task | None] = {}
        """The tasks that wait for a thread, by their numbers."""
        self.failed: list[Exception] = []
        """Exceptions of callbacks in other threads."""
        self.turn: list[int] = []
        """Those whose turn it is; the last one is the next."""
        self.host.executors.add(self)
        super().__init__(context=context)

    @classmethod
    def of(cls, program: Program) -> ProgramExecutor:
        """Return an executor of a program, also where none of its code runs."""
        made: ProgramExecutor = type.__call__(cls, program=program)
        return made

    def __del__(self) -> None:
        """Leave the guard conditions to the context, if that was destroyed before."""
        with suppress(InvalidHandle, AttributeError):
            super().__del__()  # type: ignore[no-untyped-call]  # of rclpy

    # ---- threads -------------------------------------------------------------------------

    @property
    def is_spinning(self) -> bool:
        """Whether the program waits in it, or it serves without that."""
        return any(not spin.wait.over.is_over for spin in self._spins)

    def free(self) -> ExecutorSpin | None:
        """Return what can serve a callback now."""
        for spin in reversed(self._spins):
            if spin.left != 0 and not spin.busy and not spin.wait.over.is_over:
                return spin
        return None

    def life_for(self, spin: ExecutorSpin) -> Life:
        """Return the thread in which a callback runs."""
        life: Life = (spin.caller or self.program).life
        return life

    def free_life(self, life: Life) -> None:
        """Note that a callback has left its thread."""

    def count(self, call: Call) -> None:
        """Note for those that spin a number of times that a callback has ended."""
        for spin in self._spins:
            if spin.left > 0 and spin.caller is not call:
                spin.left -= 1
                if spin.left == 0:
                    spin.wait.over.set_result(True)

    # ---- the API of rclpy ----------------------------------------------------------------

    @override
    def add_node(self, node: Node) -> bool:
        if node in self._ordered:
            return False
        if node.executor is None:
            self.wake()  # it may have got entities while no executor had it
        self._ordered.append(node)
        super().add_node(node)
        self.host.serve(node, self)
        return True

    @override
    def remove_node(self, node: Node) -> None:
        if node in self._ordered:
            self._ordered.remove(node)
            super().remove_node(node)
            self.host.unserve(node, self)

    @override
    def get_nodes(self) -> list[Node]:
        return list(self._ordered)

    @override
    def wake(self) -> None:
        self.host.wake(self)

    @override
    def create_task(
        self, callback: Callable[..., Any] | Coroutine[Any, Any, Any], *args: Any, **kwargs: Any
    ) -> Task:
        return self.host.create_task(self, callback, args, kwargs)

    @override
    def shutdown(self, timeout_sec: float | None = None) -> bool:
        for node in tuple(self._ordered):
            self.remove_node(node)
        for spin in self._spins:
            spin.wait.over.set_result(True)
        return super().shutdown(timeout_sec)

    @override
    def spin(self) -> None:
        while self._context.ok() and not self._is_shutdown:
            self._serve(ENDLESS, None)

    @override
    def spin_once(self, timeout_sec: float | None = None) -> None:
        self._serve(1, timeout_sec)

    @override
    def spin_once_until_future_complete(self, future: Future, timeout_sec: Any = None) -> None:
        limit_s = timeout_sec.timeout if isinstance(timeout_sec, TimeoutObject) else timeout_sec
        self._serve(1, limit_s, future)

    @override
    def spin_until_future_complete(self, future: Future, timeout_sec: float | None = None) -> None:
        if self._context.ok() and not self._is_shutdown:
            self._serve(ENDLESS, timeout_sec, future)

    def keep_spinning(self) -> None:
        """Serve from now on, as if the program span it in a thread."""
        self._spins.append(ExecutorSpin(self, None, ENDLESS))

    def stop(self, *, from_within: Call | None) -> None:
        """End what spins, since the context has been shut down."""
        for spin in self._spins:
            is_own = from_within is not None and from_within.spin is spin
            ends = is_own or self.hands_over
            spin.wait.over.set_result(True if ends else ExternalShutdownException())

    def _serve(self, callbacks: int, timeout_s: float | None, future: Future | None = None) -> None:
        """Let callbacks run, until their number, a time or a future ends it."""
        call = current_call()
        if call is None:
            raise RuntimeError("only the code of a program spins its executor")
        if not self._context.ok():
            raise ExternalShutdownException
        if future is not None and (future.done() or future.cancelled()):
            return
        timeout_s = None if timeout_s is None or timeout_s < 0 else timeout_s
        spin = ExecutorSpin(self, call, callbacks)
        spin.wait.is_timed = timeout_s is not None
        if future is not None:
            spin.wait.what = "spins until a future is done"
            future.add_done_callback(Waker(spin.wait))
        self._spins.append(spin)
        try:
            limit_ns = None if timeout_s is None else round(timeout_s * NS)
            self.host.wait(spin.wait, limit_ns)
        finally:
            self._spins.remove(spin)


class Waker:
    """A done callback of a future that ends a wait at once, not as a task."""

    def __init__(self, wait: CallWait) -> None:
        self._wait = wait

    def __call__(self, _: Future) -> None:
        """End the wait."""
        self._wait.over.set_result(True)


class SingleThreadedExecutor(ProgramExecutor, metaclass=StandIn):
    """Runs callbacks in the thread that spins."""

    _stands_for = executors.SingleThreadedExecutor


class MultiThreadedExecutor(ProgramExecutor, metaclass=StandIn):
    """Runs callbacks in a pool of threads."""

    _stands_for = executors.MultiThreadedExecutor
    hands_over = True

    def __init__(
        self, num_threads: int | None = None, *, context: Context | None = None, program: Any = None
    ) -> None:
        super().__init__(context=context, program=program)
        self.most = len(os.sched_getaffinity(0)) if num_threads is None else num_threads

    def wait_for_callbacks(self) -> None:
        """Wait until no callback runs; called by the code of the program."""
        if not self.blocked:
            return
        wait = CallWait("waits for callbacks in other threads")
        self.host.polls[wait] = lambda: not self.blocked
        try:
            self.host.wait(wait)
        finally:
            del self.host.polls[wait]

    @override
    def free(self) -> ExecutorSpin | None:
        if len(self.blocked) >= self.most:
            return None
        for spin in reversed(self._spins):
            if spin.left != 0 and not spin.wait.over.is_over:
                return spin
        return None

    @override
    def life_for(self, spin: ExecutorSpin) -> Life:
        return self._lives.pop() if self._lives else self.host.new_life()

    @override
    def free_life(self, life: Life) -> None:
        self._lives.append(life)
        self._lives.sort(key=lambda each: -each.ident)


class FreeExecutor(MultiThreadedExecutor):
    """Serves the nodes that a factory has made: nothing of a program spins them.

    It has a thread for each callback. A node spins it only to wait.
    """

    def __init__(self, *, context: Context, program: Any) -> None:
        super().__init__(1, context=context, program=program)
        self.own = _OwnSpin(self, None, ENDLESS)

    @override
    def free(self) -> ExecutorSpin | None:
        return self.own
