"""One behaviour under several executors: ours, and rclpy's own on a simulated clock."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy.clock import ROSClock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from rclpy.time import Time
from std_msgs.msg import Int64

from bt_mission.ros.executors.live import LiveExecutor
from bt_mission.ros.graph import destroy_actions
from bt_mission.ros.virtual_time import NothingDueError, VirtualTimeExecutor
from bt_mission.ros.virtual_time.discovery import pause

S = 1_000_000_000
MS = 1_000_000
START_NS = S
STRIDE_NS = 50 * MS
"""How rclpy's executor is moved on; periods of behaviours are multiples of it."""

IDLE_PASSES = 3
PATIENCE = 5_000

Log = dict[str, list[str]]
"""What happened, for each who took part: between two of them an executor may choose the order."""


class Play(ABC):
    """What a behaviour has at hand. Exceptions that come out of the executor are logged."""

    executor: Executor

    def __init__(self, context: Context) -> None:
        self.context = context
        self.log: Log = defaultdict(list)
        self._nodes: list[Node] = []

    def node(self, name: str, *, served: bool = True) -> Node:
        """A node on the simulated clock."""
        node = Node(name, context=self.context, enable_rosout=False, start_parameter_services=False)
        self._nodes.append(node)
        self._start_clock(node)
        if served:
            self.executor.add_node(node)
        return node

    def say(self, who: str, what: object) -> None:
        """Log what somebody who takes part has done or seen."""
        self.log[who].append(str(what))

    def hear(self, who: str) -> Callable[[Any], None]:
        """A subscription's callback that logs the data of its messages."""
        return lambda message: self.say(who, message.data)

    def ms(self, node: Node) -> int:
        """Milliseconds of simulated time since the start, by the clock of a node."""
        return int(node.get_clock().now().nanoseconds - START_NS) // MS

    def release(self, gate: Future, result: Any = None) -> None:
        """Give a future its result, and serve what waited for it."""
        gate.set_result(result)
        self.settle()

    def pipe(self, node: Node, callback: Callable[..., Any], **options: Any) -> Callable[..., None]:
        """Have a node listen to itself on a topic; return what publishes numbers there."""
        publisher = node.create_publisher(Int64, "count", 10)
        node.create_subscription(Int64, "count", loose(callback), 10, **options)

        def publish(*numbers: int) -> None:
            for number in numbers:
                publisher.publish(Int64(data=number))

        return publish

    def wait_for(self, condition: Callable[[], object]) -> None:
        """Serve until something is so that the middleware's own threads bring about."""
        for _ in range(PATIENCE):
            self.settle()
            if condition():
                return
            pause(self.context)
        raise AssertionError("it never came")

    def close(self) -> None:
        """Take everything down."""
        for node in self._nodes:
            node.destroy_node()
            destroy_actions(node)
        self.executor.shutdown()

    @abstractmethod
    def settle(self) -> None:
        """Serve until nothing more happens at this instant."""

    @abstractmethod
    def advance(self, seconds: float) -> None:
        """Let time go on, and serve all that is due."""

    @abstractmethod
    def _start_clock(self, node: Node) -> None: ...

    def _guarded(self, function: Callable[[], Any]) -> bool:
        """Call; tells whether it ended without an exception, which is logged."""
        try:
            function()
        except Exception as error:  # noqa: BLE001 - whatever a behaviour raises
            self.say("executor", f"{type(error).__name__}: {error}")
            return False
        return True


class LockstepPlay(Play):
    """Under our executor of virtual time."""

    executor: VirtualTimeExecutor

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.executor = VirtualTimeExecutor(context=context, start_ns=START_NS)

    def settle(self) -> None:
        self.advance(0.0)

    def advance(self, seconds: float) -> None:
        while not self._guarded(self.executor.run_until_quiet):
            pass
        end_ns = self.executor.now_ns + round(seconds * S)
        self.executor.call_at(end_ns, lambda: None)
        try:
            while self.executor.next_due_ns() <= end_ns:
                self._guarded(self.executor.step)
        except NothingDueError:
            pass

    def _start_clock(self, node: Node) -> None:
        _set_time(node, START_NS)


class StridingPlay(Play):
    """Under an executor that leaves time to others.

    Time goes on in strides, and for all nodes at once: through ``/clock`` each would learn of it
    on its own, and hear of the others' deeds before its own clock had moved.
    """

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._now_ns = START_NS

    def settle(self) -> None:
        idle = 0
        while idle < IDLE_PASSES:
            idle = 0 if self._pass() else idle + 1

    def advance(self, seconds: float) -> None:
        self.settle()
        end_ns = self._now_ns + round(seconds * S)
        while self._now_ns < end_ns:
            self._now_ns += STRIDE_NS
            for node in self._nodes:
                _set_time(node, self._now_ns)
            self.settle()

    @abstractmethod
    def _pass(self) -> bool:
        """Serve all that is ready; tells whether anything came of it."""

    def _start_clock(self, node: Node) -> None:
        _set_time(node, self._now_ns)


class StockPlay(StridingPlay):
    """Under rclpy's single-threaded executor."""

    executor: _Counting

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.executor = _Counting(context=context)

    def _pass(self) -> bool:
        known = set(self.executor.handled)
        self.executor.handled.clear()
        count = -1
        while count < len(self.executor.handled):
            count = len(self.executor.handled)
            self._guarded(lambda: self.executor.spin_once(timeout_sec=0))
        return any(task not in known or task.done() for task in self.executor.handled)


class LivePlay(StridingPlay):
    """Under our executor of live runs."""

    executor: LiveExecutor

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.executor = LiveExecutor(context=context)

    def _pass(self) -> bool:
        served: list[bool] = []
        is_well = self._guarded(lambda: served.append(self.executor.serve(0)))
        return not is_well or any(served)


class _Counting(SingleThreadedExecutor):
    """rclpy's, which notes what it serves; so it is known when there is nothing more."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.handled: list[Any] = []

    def wait_for_ready_callbacks(self, *args: Any, **kwargs: Any) -> Any:
        ready: Any = super().wait_for_ready_callbacks(*args, **kwargs)
        self.handled.append(ready[0])
        return ready


def loose(callback: Callable[..., Any]) -> Any:
    """A callback of a form that rclpy takes and its annotations leave out: a coroutine, or more."""
    return callback


def _set_time(node: Node, time_ns: int) -> None:
    clock = node.get_clock()
    assert isinstance(clock, ROSClock)
    with clock.handle:
        clock.handle.set_ros_time_override_is_enabled(True)
    clock.set_ros_time_override(Time(nanoseconds=time_ns, clock_type=ClockType.ROS_TIME))


@contextmanager
def play(kind: type[Play]) -> Iterator[Play]:
    """A play in a context of its own."""
    context = Context()
    rclpy.init(context=context)
    playing = kind(context)
    try:
        yield playing
    finally:
        playing.close()
        context.try_shutdown()


def perform(behaviour: Callable[[Play], None], kind: type[Play]) -> Log:
    """What happens when a behaviour is played under one executor."""
    with play(kind) as playing:
        behaviour(playing)
        return dict(playing.log)
