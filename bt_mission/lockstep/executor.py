"""The virtual clock: an rclpy executor under which time moves only when nothing is in flight.

A stock executor waits for whatever comes first, so what a callback sees depends on the wall
clock and on the scheduler. :class:`LockstepExecutor` turns that round. It owns the ROS time of
every node it serves and repeats one step:

1. find the next instant at which anything is due: a timer, or the world (a simulator);
2. let the world advance to it and publish what is due;
3. set the ROS clock of every node to it, and call what was asked for at this instant;
4. serve callbacks until none is ready ("quiet"), what passes between nodes through its taps;
5. fire the timers that are due, one at a time, and become quiet again after each.

Nodes, and the entities of a node, are served in the order of their creation, so the same inputs
give the same sequence of callbacks in every process. Step 4 ends with the truth only if a
message is in the reader's queue before ``publish`` returns. That holds for rmw_fastrtps_cpp
within one process, and :func:`bt_mission.lockstep.self_test` proves it on the machine at hand.

The executor runs on the caller's thread and starts none. Coroutine callbacks and tasks are
resumed after every round of callbacks, as under rclpy's own executors.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Coroutine
from operator import itemgetter
from typing import TYPE_CHECKING, Any, Protocol

from rclpy.clock_type import ClockType
from rclpy.executors import Executor, ShutdownException
from rclpy.task import Task
from rclpy.time import Time

from bt_mission.common.errors import BtMissionError
from bt_mission.lockstep.entities import Entities, describe
from bt_mission.lockstep.matching import settle
from bt_mission.lockstep.serving import Rest, serve, serve_timer
from bt_mission.lockstep.taps import Passing, Side, Taps

if TYPE_CHECKING:
    from rclpy.context import Context
    from rclpy.node import Node

CALLBACKS_PER_INSTANT = 100_000
"""Callbacks after which an instant of virtual time is taken for one that never ends."""


class TimeStuckError(BtMissionError):
    """Callbacks keep each other busy, so virtual time cannot advance."""


class NothingDueError(BtMissionError):
    """There is neither a timer nor a world that could move time."""


class World(Protocol):
    """What moves with time besides the timers, such as a simulator."""

    @property
    def next_due_ns(self) -> int:
        """The next instant at which something will be published, ns."""

    def advance_to(self, time_ns: int) -> None:
        """Move on to ``time_ns`` and publish everything due at or before it."""


class LockstepExecutor(Executor):
    """Serves nodes on one virtual clock.

    :param start_ns: the first instant, ns; above zero, since ROS takes zero for "not set".
    :param world: what moves with time besides the timers; may be set later.
    :param context: the rclpy context of the nodes.
    """

    def __init__(
        self,
        *,
        start_ns: int = 1_000_000_000,
        world: World | None = None,
        context: Context | None = None,
    ) -> None:
        self._structure_changed = True
        super().__init__(context=context)
        if start_ns <= 0:
            raise ValueError(
                f"start_ns must be above 0 (ROS takes 0 for 'not set'), got {start_ns}"
            )
        self.world = world
        self.callbacks_served = 0
        self.taps = Taps()
        self._now_ns = start_ns
        self._ordered_nodes: list[Node] = []
        self._entities = Entities([], self._context)
        self._alarms: list[tuple[int, Callable[[], Any]]] = []
        self._new_tasks: list[Task] = []
        self._waiting_tasks: list[Task] = []
        self._suspended: list[tuple[Coroutine[Any, Any, None], Any]] = []

    # ---- nodes and time ------------------------------------------------------------------

    @property
    def now_ns(self) -> int:
        """The present instant of virtual time, ns."""
        return self._now_ns

    def add_node(self, node: Node) -> bool:
        """Serve ``node`` after all nodes added before it, on the virtual clock.

        Its timers start anew: each is first due one period from now.
        """
        if node in self._ordered_nodes:
            return False
        self._ordered_nodes.append(node)
        node.executor = self
        clock = node.get_clock().handle
        with clock:
            clock.set_ros_time_override_is_enabled(True)
        node.get_clock().set_ros_time_override(self._ros_time())
        for timer in node.timers:
            timer.reset()
        self._structure_changed = True
        return True

    def remove_node(self, node: Node) -> None:
        """Stop serving ``node``; its clock stays where it is."""
        if node in self._ordered_nodes:
            self._ordered_nodes.remove(node)
            self._structure_changed = True

    def get_nodes(self) -> list[Node]:
        """The nodes served, in order."""
        return list(self._ordered_nodes)

    def wake(self) -> None:
        """Note that an entity was made or destroyed (rclpy calls this)."""
        self._structure_changed = True

    def call_at(self, time_ns: int, function: Callable[[], Any]) -> None:
        """Call a function at an instant: after the world has moved there, before any callback.

        :raises ValueError: when that instant is past.
        """
        if time_ns < self._now_ns:
            raise ValueError(f"{time_ns} ns is past: it is {self._now_ns} ns")
        self._alarms.append((time_ns, function))
        self._alarms.sort(key=itemgetter(0))  # those of one instant stay in order

    def create_task(
        self, callback: Callable[..., Any] | Coroutine[Any, Any, Any], *args: Any, **kwargs: Any
    ) -> Task:
        """Run a function or coroutine within the present instant; gives its future."""
        task = Task(callback, args, kwargs, executor=self)
        self._new_tasks.append(task)
        return task

    # ---- stepping ------------------------------------------------------------------------

    def next_due_ns(self) -> int:
        """The next instant at which a timer, the world or a delayed delivery is due, ns.

        :raises NothingDueError: when there is neither.
        """
        self._refresh()
        wait_ns = self._entities.ns_until_next_timer(any_suspended=bool(self._suspended))
        due = [] if wait_ns is None else [self._now_ns + wait_ns]
        if self.world is not None:
            due.append(self.world.next_due_ns)
        held_ns = self.taps.next_due_ns()
        if held_ns is not None:
            due.append(held_ns)
        if self._alarms:
            due.append(self._alarms[0][0])
        if not due:
            raise NothingDueError("virtual time cannot move: no timer is set and there is no world")
        return max(min(due), self._now_ns)

    def step(self) -> int:
        """Jump to the next due instant and serve it; gives that instant, ns."""
        time_ns = self.next_due_ns()
        if self.world is not None:
            self.world.advance_to(time_ns)
        self._now_ns = time_ns
        time = self._ros_time()
        for node in self._ordered_nodes:
            node.get_clock().set_ros_time_override(time)
        while self._alarms and self._alarms[0][0] <= time_ns:
            self._alarms.pop(0)[1]()
        self.run_until_quiet()
        for timer in tuple(self._entities.timers):
            if self._suspended and not timer.callback_group.can_execute(timer):
                continue
            was_due, rest = serve_timer(timer)
            if was_due:
                self.callbacks_served += 1
                self._begin(timer, rest)
                self.run_until_quiet()
        return self._now_ns

    def run_until_quiet(self) -> None:
        """Serve callbacks at the present instant until none is ready.

        :raises TimeStuckError: when they do not end.
        """
        limit = self.callbacks_served + CALLBACKS_PER_INSTANT
        while self._serve_round():
            if self.callbacks_served > limit:
                self._report_stuck()

    def spin_once(self, timeout_sec: float | None = None) -> None:  # noqa: ARG002 - rclpy's form
        """One step; ``timeout_sec`` is not used, since nothing here waits for the wall clock."""
        if self._is_shutdown:
            raise ShutdownException
        self.step()

    def spin_once_until_future_complete(
        self, future: Any, timeout_sec: float | None = None
    ) -> None:
        """One step, unless ``future`` is done already."""
        if not future.done():
            self.spin_once(timeout_sec)

    # ---- inside --------------------------------------------------------------------------

    def _ros_time(self) -> Time:
        return Time(nanoseconds=self._now_ns, clock_type=ClockType.ROS_TIME)

    def passing(self, entity: Any, name: str, side: Side, message: Any) -> Passing:
        """Something that an entity was sent and has taken, for its taps."""
        return Passing(name, side, message, self._entities.owner_of(entity), self._now_ns)

    def actions_of(self, end: Any) -> tuple[str, ...]:
        """The full names of the actions that one end of an action can be of."""
        return self._entities.actions_of(end)

    def _refresh(self) -> None:
        """Read the entities again if any was made or destroyed, and see them matched."""
        while self._structure_changed:
            self._structure_changed = False
            try:
                self._entities = Entities(self._ordered_nodes, self._context)
                settle(self._ordered_nodes)
            except BaseException:
                self._structure_changed = True  # so that the next step sees it, too
                raise

    def _serve_round(self) -> list[Any]:
        """Run tasks as far as they get, then serve each ready entity once; gives those."""
        self._release()
        self._run_tasks()
        self._refresh()
        ready = self._entities.ready()
        if self._suspended:
            ready = [entity for entity in ready if entity.callback_group.can_execute(entity)]
        for entity in ready:
            if self._suspended and not entity.callback_group.can_execute(entity):
                continue
            self.callbacks_served += 1
            self._begin(entity, serve(entity, self))
            if self._structure_changed:
                break  # what is ready may be gone; the next round looks again
        return ready

    def _release(self) -> None:
        """Deliver what taps have held back until now."""
        for entity, deliver in self.taps.take_due(self._now_ns):
            self._refresh()
            if self._entities.owner_of(entity):  # it may have been destroyed since
                self.callbacks_served += 1
                self._begin(entity, deliver())

    def _begin(self, entity: Any, rest: Rest) -> None:
        """Run a callback's coroutine as far as it goes now."""
        if rest is None:
            return
        try:
            rest.send(None)
        except StopIteration:
            return
        entity.callback_group.beginning_execution(entity)
        self._suspended.append((rest, entity))

    def _run_tasks(self) -> None:
        """Resume suspended callbacks and tasks until none of them gets any further.

        What one of them raises comes out of here; the others keep their place.
        """
        limit = self.callbacks_served + CALLBACKS_PER_INSTANT
        while self._resume_tasks() or self._resume_callbacks() or self._new_tasks:
            if self.callbacks_served > limit:
                raise TimeStuckError(
                    f"virtual time is stuck at {self._now_ns / 1e9:.3f} s: tasks make tasks"
                )

    def _resume_tasks(self) -> bool:
        """Give each task a turn; tells whether one of them ended."""
        turns = deque(self._waiting_tasks + self._new_tasks)
        self._waiting_tasks, self._new_tasks = [], []
        ended = False
        try:
            while turns:
                task = turns.popleft()
                self.callbacks_served += 1
                task()
                if task.done():
                    ended = True
                    task.result()  # raises what the task raised
                elif not task.cancelled():
                    self._waiting_tasks.append(task)
        finally:
            self._waiting_tasks.extend(turns)
        return ended

    def _resume_callbacks(self) -> bool:
        """Give each suspended callback a turn; tells whether one of them ended."""
        turns = deque(self._suspended)
        self._suspended = []
        ended = False
        try:
            while turns:
                coroutine, entity = turns.popleft()
                try:
                    coroutine.send(None)
                except BaseException as end:
                    entity.callback_group.ending_execution(entity)
                    if not isinstance(end, StopIteration):
                        raise
                    ended = True
                else:
                    self._suspended.append((coroutine, entity))
        finally:
            self._suspended.extend(turns)
        return ended

    def _report_stuck(self) -> None:
        names: Counter[str] = Counter()
        for _ in range(100):
            names.update(describe(entity) for entity in self._serve_round())
        busiest = ", ".join(name for name, _ in names.most_common(3)) or "tasks"
        raise TimeStuckError(
            f"virtual time is stuck at {self._now_ns / 1e9:.3f} s: callbacks do not end; "
            f"busiest: {busiest}"
        )
