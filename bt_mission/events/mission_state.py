"""What is known of the mission of one executive and of its robot, from what they tell.

Messages may come late and out of order: the tree after its first changes, changes with gaps.
Changes count once all statuses up to the one before are known; until then they wait.
"""

from __future__ import annotations

import copy
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

from py_trees.common import Status

from bt_mission.events import messages
from bt_mission.events.events import (
    FINAL,
    GoalChanged,
    LogLine,
    MissionEvent,
    MissionStarted,
    MissionStateChanged,
    NodeProgress,
    NodeProgressed,
    NodeStatusChanged,
    RequirementChanged,
    VariableChanged,
)
from bt_mission.events.log import LOG_ENTRIES, LogEntry, entry_of
from bt_mission.events.robot_state import RobotState

WAITING_CHANGES = 10_000
"""Changes kept until the statuses before them are known; beyond it the oldest are dropped."""

ROBOT = (
    tuple,
    messages.ScanPoints,
    messages.Map,
    messages.Zones,
    messages.BatteryState,
    messages.OtherRobot,
)
"""The classes of :data:`bt_mission.events.messages.Robot`."""

State = TypeVar("State", "MissionState", RobotState)


MOST_ENDS = 4
"""How often a node has ended that is kept."""


@dataclass(frozen=True)
class NodeEnd:
    """How and when a node has ended, ns; halted is :attr:`Status.INVALID`. None was not seen."""

    status: Status
    time_ns: int | None
    ran_ns: int | None
    message: str


class MissionState:
    """One mission after another, as an executive tells of them. Feed it with :meth:`take`."""

    def __init__(self) -> None:
        self.tree: MissionStarted | None = None
        self.state: MissionStateChanged | None = None
        self.robot = RobotState()
        self.log: deque[LogEntry] = deque(maxlen=LOG_ENTRIES)
        self.now_ns = 0
        """The newest ROS time that was told, ns."""
        self.sequence: int | None = None
        """Number of the newest changes that are known; None while statuses are not known."""
        self.statuses: list[Status] = []
        self.messages: list[str] = []
        self.since_ns: list[int | None] = []
        """When each node got its status, ns; None where that was not seen."""
        self.ran_ns: list[int | None] = []
        """How long each node had run when it last ended, ns; None where that was not seen."""
        self.ends: list[tuple[NodeEnd, ...]] = []
        """How each node has ended the last few times, the newest last."""
        self.is_leaf: list[bool] = []
        self.running: dict[int, None] = {}
        """Indices of the nodes that run, the newest last."""
        self.progress: dict[int, NodeProgress] = {}
        self.ticks: int | None = None
        self.goals_sent: int | None = None
        """Neither is known before the first details."""
        self.goals: dict[str, GoalChanged] = {}
        """Every goal that was told of, in the order sent."""
        self.variables: dict[str, str] = {}
        self.breakpoints: tuple[str, ...] = ()
        self._node_details = messages.NodeDetails("", {})
        self._requirements = messages.Requirements(0, "", ())
        self._running_children: list[int] = []
        self._waiting: deque[messages.Changes] = deque(maxlen=WAITING_CHANGES)
        self._early: deque[messages.Changes] = deque(maxlen=WAITING_CHANGES)
        """Changes of a run whose tree has not come yet."""

    def copied(self) -> MissionState:
        """Return the same once more; both can go on by themselves."""
        other = _copied(self)
        other.robot = _copied(self.robot)
        return other

    @property
    def needs_statuses(self) -> bool:
        """Has somebody to ask for all statuses at once?"""
        return self.tree is not None and self.sequence is None

    @property
    def status(self) -> str:
        """The mission's state in one word; empty where nothing is known."""
        return self.state.status if self.state else ""

    @property
    def elapsed_ns(self) -> int:
        """ROS time since the mission's start, ns; once it has ended, to its end."""
        if self.tree is None:
            return 0
        state = self.state
        is_over = state is not None and state.run == self.tree.run and state.status in FINAL
        end_ns = state.time_ns if is_over and state is not None else self.now_ns
        return max(end_ns - self.tree.time_ns, 0)

    def details(self, index: int) -> tuple[str, ...]:
        """What a node is asked to do: fields of its goal, conditions, limits, outputs."""
        known, tree = self._node_details, self.tree
        if tree is None or known.run != tree.run:
            return ()
        return known.nodes.get(tree.nodes[index].path, ())

    @property
    def requirements(self) -> tuple[RequirementChanged, ...]:
        """What each requirement of the mission has come to; empty where none is known."""
        known = self._requirements
        return known.requirements if self.tree and known.run == self.tree.run else ()

    @property
    def violated(self) -> tuple[RequirementChanged, ...]:
        """Those that are violated."""
        return tuple(one for one in self.requirements if one.verdict == "violated")

    @property
    def tip(self) -> int | None:
        """Of the nodes that run without running children, the one that started last."""
        for index in reversed(self.running):
            if not self._running_children[index]:
                return index
        return None

    def take(self, message: messages.Told | messages.Robot) -> list[MissionEvent]:
        """Take in what an executive or its robot tells; gives what has happened, in order."""
        match message:
            case MissionStarted():
                happening = self._begin(message)
            case messages.NodeDetails():
                self._node_details = message
                return []
            case messages.Requirements():
                happening = self._take_requirements(message)
            case messages.Changes():
                happening = self._take_changes(message)
            case messages.Statuses():
                happening = self._take_statuses(message)
            case MissionStateChanged():
                happening = self._take_state(message)
            case messages.DetailsUpdate():
                happening = self._take_details(message)
            case LogLine():
                happening = self._take_line(message)
            case _:
                self.robot.take(message)
                return []
        happened = list(happening)
        self.log.extend(entry for one in happened if (entry := entry_of(one)) is not None)
        return happened

    def _begin(self, tree: MissionStarted) -> Iterator[MissionEvent]:
        if self.tree is not None and tree.run == self.tree.run:
            return
        count = len(tree.nodes)
        self.tree, self.sequence, self.now_ns = tree, None, tree.time_ns
        self.statuses, self.messages = [Status.INVALID] * count, [""] * count
        self.since_ns, self.ran_ns = [None] * count, [None] * count
        self.ends = [()] * count
        self.is_leaf, self._running_children = [True] * count, [0] * count
        for index, node in enumerate(tree.nodes):
            if index:
                self.is_leaf[node.parent] = False
        self.running, self.progress, self.goals, self.variables = {}, {}, {}, {}
        self.ticks = self.goals_sent = None
        self._waiting.clear()
        self._waiting.extend(one for one in self._early if one.run == tree.run)
        self._early.clear()
        self.robot.trail.clear()
        yield tree
        yield from self.requirements  # they may come before the tree
        yield from self._catch_up()

    def _take_requirements(self, told: messages.Requirements) -> Iterator[MissionEvent]:
        before = {replace(one, time_ns=0) for one in self.requirements}
        self._requirements = told
        for one in self.requirements:
            if replace(one, time_ns=0) not in before:
                yield one

    def _take_changes(self, changes: messages.Changes) -> Iterator[MissionEvent]:
        if self.tree is None or changes.run != self.tree.run:
            self._early.append(changes)
            return
        self._waiting.append(changes)
        yield from self._catch_up()

    def _catch_up(self) -> Iterator[MissionEvent]:
        """Apply the changes that follow what is known."""
        while self._waiting:
            changes = self._waiting[0]
            # Before the first changes of a run nothing has happened.
            known = 0 if self.sequence is None and changes.sequence == 1 else self.sequence
            if known is None or changes.sequence > known + 1:
                self.sequence = None
                return
            self._waiting.popleft()
            if changes.sequence == known + 1:
                self.sequence = changes.sequence
                self._see(changes.time_ns)
                for one in changes.changes:
                    yield from self._set(one, changes.time_ns)

    def _take_statuses(self, answer: messages.Statuses) -> Iterator[MissionEvent]:
        if self.tree is None or answer.run != self.tree.run:
            return
        if self.sequence is not None and answer.sequence < self.sequence:
            return  # older than what has come since
        self.sequence = answer.sequence
        for one in answer.statuses:
            yield from self._set(one, None)
        for progress in self.progress.values():
            self._apply(progress)
        yield from self._catch_up()

    def _set(self, one: messages.NodeStatus, time_ns: int | None) -> Iterator[MissionEvent]:
        """Give a node its status. Without a time only what differs counts as a change."""
        index = one.node
        if self.tree is None or index >= len(self.statuses):
            return
        before = self.statuses[index]
        self.messages[index] = one.message
        if time_ns is None and before is one.status:
            return
        since_ns = self.since_ns[index]
        if before is Status.RUNNING and one.status is not Status.RUNNING:
            known = time_ns is not None and since_ns is not None
            self.ran_ns[index] = time_ns - since_ns if known else None  # type: ignore[operator]
        self.statuses[index], self.since_ns[index] = one.status, time_ns
        self._count_running(index, before, one.status)
        if self._has_only_ended(one, before, time_ns):
            return
        node = self.tree.nodes[index]
        yield NodeStatusChanged(time_ns, index, node, one.status, one.message, self.is_leaf[index])

    def _has_only_ended(
        self, one: messages.NodeStatus, before: Status, time_ns: int | None
    ) -> bool:
        """Note an end; give whether nothing has happened, as where a loop begins a new round.

        A node is reset in it, and may end at once as it did in the last one.
        """
        if one.status is Status.RUNNING:
            return False
        index, has_run = one.node, before is Status.RUNNING
        if one.status is Status.INVALID and not has_run:
            self.since_ns[index] = None
            return True
        ends = self.ends[index]
        ran_ns = self.ran_ns[index] if has_run else 0
        self.ends[index] = (*ends, NodeEnd(one.status, time_ns, ran_ns, one.message))[-MOST_ENDS:]
        return not has_run and bool(ends) and ends[-1].status is one.status

    def _count_running(self, index: int, before: Status, after: Status) -> None:
        assert self.tree is not None
        change = (after is Status.RUNNING) - (before is Status.RUNNING)
        if index:
            self._running_children[self.tree.nodes[index].parent] += change
        if after is Status.RUNNING:
            self.running.pop(index, None)
            self.running[index] = None
        else:
            self.running.pop(index, None)
            self.progress.pop(index, None)

    def _take_state(self, state: MissionStateChanged) -> Iterator[MissionEvent]:
        if self.state == state:
            return
        if self.tree is not None and state.run == self.tree.run:
            self._see(state.time_ns)
        self.state = state
        yield state

    def _take_details(self, details: messages.DetailsUpdate) -> Iterator[MissionEvent]:
        tree = self.tree
        if tree is None or details.run != tree.run:
            return
        self._see(details.time_ns)
        self.ticks, self.goals_sent = details.ticks, details.goals_sent
        self.breakpoints = details.breakpoints
        for progress in details.running:
            if progress.node < len(tree.nodes) and self.progress.get(progress.node) != progress:
                self.progress[progress.node] = progress
                self._apply(progress)
                yield NodeProgressed(details.time_ns, tree.nodes[progress.node], progress)
        for goal in details.goals:
            if self.goals.get(goal.id) != goal:
                self.goals[goal.id] = goal
                yield goal
        for name, value in details.variables:
            if self.variables.get(name) != value:
                self.variables[name] = value
                yield VariableChanged(details.time_ns, name, value)

    def _apply(self, progress: NodeProgress) -> None:
        """Details may come before the statuses, or after a node has ended."""
        if progress.node in self.running:
            self.messages[progress.node] = progress.message
            self.since_ns[progress.node] = progress.since_ns

    def _take_line(self, line: LogLine) -> Iterator[MissionEvent]:
        if self.tree is not None and line.run == self.tree.run:
            self._see(line.time_ns)
            yield line

    def _see(self, time_ns: int) -> None:
        self.now_ns = max(self.now_ns, time_ns)


def _copied(state: State) -> State:
    """Return a copy with containers of its own; what is in them is frozen."""
    other = copy.copy(state)
    for name, value in vars(state).items():
        if isinstance(value, list | dict | deque):
            setattr(other, name, value.copy())
    return other
