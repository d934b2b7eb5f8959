"""The virtual clock: an rclpy executor under which time moves only when nothing is in flight.

A stock executor waits for whatever comes first, so what a callback sees depends on the wall
clock and on the scheduler. :class:`VirtualTimeExecutor` turns that round. It owns the ROS time of
every node it serves and repeats one step:

1. find the next instant at which anything is due: a timer, or the world (a simulator);
2. let the world advance to it and publish what is due;
3. set the ROS clock of every node to it, and call what was asked for at this instant;
4. serve callbacks until none is ready ("quiet"), what passes between nodes through its taps;
5. fire the timers that are due, one at a time, and become quiet again after each.

What is ready is served by kind (subscriptions, services, clients, guard conditions, waitables),
then by node and entity in the order of their creation (`bt_mission.ros.executors.entities`). So
the same inputs give the same sequence of callbacks in every process. Step 4 ends with the truth
only if a message is in the reader's queue before ``publish`` returns. That holds for
rmw_fastrtps_cpp within one process, and :func:`bt_mission.ros.virtual_time.self_test` proves it on
the machine at hand.

The executor runs on the caller's thread and starts none. Coroutine callbacks and tasks are
resumed after every round of callbacks, as under rclpy's own executors.
"""

from __future__ import annotations

import inspect
from bisect import insort
from collections import Counter
from collections.abc import Callable, Coroutine, Sequence
from operator import itemgetter
from typing import Any, Protocol

from rclpy.context import Context
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.task import Task
from typing_extensions import override

from bt_mission.base.errors import BtMissionError
from bt_mission.ros.executors.arrivals import Arrived
from bt_mission.ros.executors.callbacks import call_timer, rest_of, take_timer
from bt_mission.ros.executors.entities import Entities, describe, describe_timer
from bt_mission.ros.virtual_time.discovery import wait_for_matching
from bt_mission.ros.virtual_time.execute_callbacks import ExecuteCallbacks, is_execute_callback
from bt_mission.ros.virtual_time.node_clocks import Clocks
from bt_mission.ros.virtual_time.spin import (
    NestedStepError,
    NothingDueError,
    Spinning,
    TimeStuckError,
)

CALLBACKS_PER_INSTANT = 100_000
"""The limit of callbacks within an instant of virtual time; beyond it the instant counts as
endless.
"""

Alarm = tuple[int, Callable[[], Any]]

_AT = itemgetter(0)

_NEVER = 2**63
"""Nanoseconds: beyond all that a ROS clock shows."""

STEPS_PER_INSTANT = 1_000
"""Steps in a row that do not move time, after which it is taken for stuck."""


class SteppedWorld(Protocol):
    """A part of the world that moves with time besides the timers, such as a simulator."""

    @property
    def next_due_ns(self) -> int:
        """The next instant at which something will be published, ns."""

    def advance_to(self, time_ns: int) -> None:
        """Move on to ``time_ns`` and publish everything due at or before it."""


class VirtualTimeExecutor(Spinning):
    """Serves nodes on one virtual clock.

    Args:
        start_ns: The first instant, ns; above zero, since ROS takes zero for "not set".
        world: The part of the world that moves with time besides the timers; may be set later.
        context: The rclpy context of the nodes.
    """

    def __init__(
        self,
        *,
        start_ns: int = 1_000_000_000,
        world: SteppedWorld | None = None,
        context: Context | None = None,
    ) -> None:
        super().__init__(context=context)
        if start_ns <= 0:
            raise ValueError(
                f"start_ns must be above 0 (ROS takes 0 for 'not set'), got {start_ns}"
            )
        self.world = world
        self.clocks = Clocks()
        self._now_ns = start_ns
        self._steps_here = 0
        self._is_serving = False
        self._alarms: list[Alarm] = []
        self._execute_callbacks = ExecuteCallbacks()
        self.taps.can_take = self._can_be_served

    # ---- nodes and time ------------------------------------------------------------------

    @property
    def now_ns(self) -> int:
        """The present instant of virtual time, ns."""
        return self._now_ns

    @override
    def add_node(self, node: Node) -> bool:
        """Serve ``node`` after all nodes added before it, on the virtual clock.

        Its timers restart: each is first due one period from now.
        """
        if not super().add_node(node):
            return False
        self.clocks.start(node, self._now_ns)
        return True

    def take_node(self, node: Node) -> None:
        """Serve a node whose own executor says when; its timers continue."""
        self._take_node(node)

    def call_at(self, time_ns: int, function: Callable[[], Any]) -> Alarm:
        """Call a function at an instant: after the world has moved there, before any callback.

        Returns:
            What :meth:`cancel_call` takes.

        Raises:
            ValueError: When that instant is past.
        """
        if time_ns < self._now_ns:
            raise ValueError(f"{time_ns} ns is in the past: it is {self._now_ns} ns")
        alarm = (time_ns, function)
        insort(self._alarms, alarm, key=_AT)  # those of the same instant keep their order
        return alarm

    def cancel_call(self, alarm: Alarm) -> None:
        """Do not call the function, if it has not been called."""
        if alarm in self._alarms:
            self._alarms.remove(alarm)

    @override
    def create_task(
        self, callback: Callable[..., Any] | Coroutine[Any, Any, Any], *args: Any, **kwargs: Any
    ) -> Task:
        """Run a function or coroutine in the next round. Return its future."""
        if self.host is not None:
            task = self.host.task_of_call(callback, args, kwargs)
            if task is not None:
                return task
        if is_execute_callback(callback):
            call = self._execute_callbacks.call
            return super().create_task(call, self._actions_served, callback, *args, **kwargs)
        return super().create_task(callback, *args, **kwargs)

    def begin_task(self, function: Callable[[], Coroutine[Any, Any, Any]]) -> Task:
        """Run a coroutine function that calls code which may block. Return its future."""
        return super().create_task(function)

    def start_task(
        self,
        callback: Any,
        args: Sequence[Any],
        kwargs: dict[str, Any],
        show: Callable[[BaseException], None] | None = None,
    ) -> Any:
        """Call what was given for a task. Return its result; a coroutine if it is one.

        Args:
            show: Prints what an execute callback raises, if it is that of a whole program.
        """
        if is_execute_callback(callback):
            call = self._execute_callbacks.call
            return call(self._actions_served, callback, *args, show=show)
        return callback if inspect.iscoroutine(callback) else callback(*args, **kwargs)

    def take_raised(self, goal_id: bytes) -> str:
        """Return once what the execute callback of a goal has raised, and where.

        Args:
            goal_id: The UUID of the goal, 16 bytes.

        Returns:
            One line; empty if nothing was raised.
        """
        return self._execute_callbacks.take_raised(goal_id)

    # ---- stepping ------------------------------------------------------------------------

    def next_due_ns(self) -> int:
        """The next instant at which a timer, the world or a delayed delivery is due, ns.

        Raises:
            NothingDueError: When there is neither.
        """
        if self._structure_changed:
            self._refresh()
        wait_ns = self._entities.ns_until_next_timer(
            can_fire=self._can_be_served if self._begun.holding or self.host else None,
            stopped=self.clocks.stopped,
        )
        due_ns = _NEVER if wait_ns is None else self._now_ns + wait_ns
        if self.world is not None and (world_ns := self.world.next_due_ns) < due_ns:
            due_ns = world_ns
        if self.taps.held and (held_ns := self.taps.next_due_ns()) is not None:
            due_ns = min(due_ns, held_ns)
        if self._alarms:
            due_ns = min(due_ns, self._alarms[0][0])
        if due_ns == _NEVER:
            if self.host is not None:
                self.host.refuse_standstill()
            raise NothingDueError
        return max(self._now_ns, due_ns)

    def step(self) -> int:
        """Jump to the next due instant and serve it. Return that instant, ns.

        Raises:
            TimeStuckError: Callbacks do not end, or time does not move.
            NestedStepError: Called in a callback.
        """
        if self._is_serving:
            raise NestedStepError
        time_ns = self.next_due_ns()
        self._steps_here = self._steps_here + 1 if time_ns == self._now_ns else 0
        if self._steps_here > STEPS_PER_INSTANT:
            raise self._stuck(f"due again and again: {self._names_of_due()}")
        if self.world is not None:
            self.world.advance_to(time_ns)
        self._now_ns = time_ns
        self.clocks.set_time(time_ns)
        if self._alarms:
            self._ring()
        self.run_until_quiet()
        self._fire_timers()
        return self._now_ns

    def run_until_quiet(self) -> None:
        """Serve callbacks at the present instant until none is ready.

        Raises:
            TimeStuckError: They do not end.
        """
        limit = self._served + CALLBACKS_PER_INSTANT
        was_serving, self._is_serving = self._is_serving, True
        try:
            while self._serve_round():
                if self._served > limit:
                    self._report_stuck()
            if self.host is not None:
                self.host.check()
        finally:
            self._is_serving = was_serving

    # ---- inside --------------------------------------------------------------------------

    @override
    def _read(self, nodes: Sequence[Node]) -> Entities:
        """Take a snapshot, and see all matched. A timer of another clock is an error."""
        for node in nodes:
            for timer in node.timers:
                if timer.clock is not node.get_clock() and type(timer.clock.handle) is _rclpy.Clock:
                    raise BtMissionError(
                        f"a timer of {node.get_name()} on a {timer.clock.clock_type.name} clock "
                        "cannot run in virtual time; create it with the clock of its node",
                        code="BT-903",
                    )
        self.clocks.keep(nodes)
        entities = Entities(nodes, self._context, self.arrivals)
        wait_for_matching(nodes)
        if self.host is not None:
            self.host.compare_qos(nodes)
        return entities

    @override
    def _can_be_served(self, entity: Any) -> bool:
        if self.host is not None and not self.host.admits(entity, self._entities.node_of(entity)):
            return False
        return super()._can_be_served(entity)

    def _actions_served(self, server: Any) -> tuple[str, ...]:
        return () if self._entities.node_of(server) is None else self.actions_of(server)

    def _serve_round(self) -> Sequence[Arrived]:
        """Run tasks as far as possible, then serve each ready entity once.

        Return those entities.
        """
        if self.taps.held:
            self._release()
        # Resume suspended callbacks and tasks until none of them advances.
        limit = self._begun.turns + CALLBACKS_PER_INSTANT
        while self._begun.resume() or (self.host is not None and self.host.take_advanced()):
            if self._begun.turns > limit:
                raise self._stuck("tasks make tasks")
        return self._serve_ready()

    def _release(self) -> None:
        """Deliver what taps have held back until now."""
        for entity, deliver in self.taps.take_due(self._now_ns):
            self._refresh()
            node = self._entities.node_of(entity)
            if node is not None:  # it may have been destroyed since
                self._served += 1
                rest = deliver() if self.host is None else self.host.call(entity, node, deliver)
                if rest is not None:
                    self._begin(entity, rest)

    def _ring(self) -> None:
        """Run the calls that are scheduled for this instant."""
        for _ in range(CALLBACKS_PER_INSTANT):
            if not self._alarms or self._alarms[0][0] > self._now_ns:
                return
            self._alarms.pop(0)[1]()
        raise self._stuck("callbacks of this instant schedule more for this instant")

    def _fire_timers(self) -> None:
        """Call the timers that are due, and become quiet again after each."""
        entities = self._entities
        for timer, handle in zip(tuple(entities.timers), entities.timer_handles, strict=True):
            if self._entities is not entities and self._entities.node_of(timer) is None:
                continue  # destroyed since the instant began, or its node was removed
            if (self._begun.holding or self.host) and not self._can_be_served(timer):
                continue
            self._is_serving = True
            try:
                was_due = take_timer(handle)
                if was_due:
                    self._served += 1
                    if self.host is None:
                        callback = timer.callback
                        outcome = callback()
                        rest = None if outcome is None else rest_of(callback, outcome)
                    else:
                        node = self._entities.node_of(timer)
                        rest = self.host.call(timer, node, call_timer, timer)
                    if rest is not None:
                        self._begin(timer, rest)
            finally:
                self._is_serving = False
            if was_due:
                self.run_until_quiet()

    def _names_of_due(self) -> str:
        names = [
            describe_timer(timer, self._entities.owner_of(timer))
            for timer in self._entities.timers
            if not timer.is_canceled() and timer.time_until_next_call() <= 0
        ]
        if self.world is not None and self.world.next_due_ns <= self._now_ns:
            names.append("the world")
        return ", ".join(names)

    def _report_stuck(self) -> None:
        names: Counter[str] = Counter()
        for _ in range(100):
            names.update(describe(arrived.entity) for arrived in self._serve_round())
        busiest = ", ".join(name for name, _ in names.most_common(3)) or "tasks"
        raise self._stuck(f"callbacks do not end; busiest: {busiest}")

    def _stuck(self, why: str) -> TimeStuckError:
        return TimeStuckError(f"virtual time is stuck at {self._now_ns / 1e9:.3f} s: {why}")
