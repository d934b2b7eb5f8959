"""The state of a mission and its robot, from their events and messages."""

from __future__ import annotations

import copy
from collections import defaultdict, deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, TypeVar

from py_trees.common import Status

from bt_mission.base.verdicts import FAILING, conclusion
from bt_mission.executive.events import events as happened
from bt_mission.executive.events.codec import fields_of
from bt_mission.executive.events.events import (
    AT_BREAKPOINT,
    ENDED,
    FINAL,
    Event,
    GoalChanged,
    RequirementChanged,
    RunStarted,
)
from bt_mission.executive.events.log import (
    LOG_ENTRIES,
    LOG_KIND,
    LogEntry,
    mission_state,
    verdict,
    words_of,
)
from bt_mission.executive.events.robot_state import RobotState

State = TypeVar("State", "MissionState", RobotState)

MOST_ENDS = 4
"""The number of ends of a node that are kept."""

MOST_GOALS = 200
"""The number of goals that are kept; beyond it the oldest ended one is dropped."""


@dataclass(frozen=True, slots=True)
class NodeEnd:
    """The status with which a node ended, and the time, ns; a halt is :attr:`Status.INVALID`.

    None was not observed.
    """

    status: Status
    time_ns: int | None
    ran_ns: int | None
    message: str


class MissionState:
    """The state of the runs of an executive, one after another. Feed it with :meth:`apply`."""

    def __init__(self) -> None:
        self.tree: RunStarted | None = None
        self.state: happened.StateChanged | None = None
        self.robot = RobotState()
        self.log: deque[LogEntry] = deque(maxlen=LOG_ENTRIES)
        self.now_ns = 0
        """ROS time of the newest event, ns."""
        self.statuses: list[Status] = []
        self.messages: list[str] = []
        self.since_ns: list[int | None] = []
        """When each node got its status, ns; None if that was not observed."""
        self.ran_ns: list[int | None] = []
        """For how long each node had run when it last ended, ns; None if that was not observed."""
        self.ends: list[tuple[NodeEnd, ...]] = []
        """The last ends of each node, the newest last."""
        self.is_leaf: list[bool] = []
        self.running: dict[int, None] = {}
        """Indices of the nodes that run, the newest last."""
        self.progress: dict[int, happened.NodeProgressed] = {}
        self.ticks: int | None = None
        self.goals_sent: int | None = None
        """Neither is known before it was sent."""
        self.goals: dict[str, GoalChanged] = {}
        """The newest state of the newest goals, in the order sent."""
        self.goals_changed_ns: dict[str, int] = {}
        """When each goal got its state, ns."""
        self._ended_goals: dict[str, None] = {}
        """The goals in `goals` that have ended, in the order of their ends."""
        self.variables: dict[str, str] = {}
        self.breakpoints: tuple[str, ...] = ()
        self._requirements: dict[str, RequirementChanged] = {}
        self.untested: list[str] = []
        """Faults and answers that were planned for the run and never happened; known at its end."""
        self._started_ns: list[int | None] = []
        """When each node last began to run, ns."""
        self._running_children: list[int] = []
        self._ended_nodes: list[NodeEnd] | None = None

    def copied(self) -> MissionState:
        """Return an independent copy."""
        other = _copied(self)
        other.robot = _copied(self.robot)
        return other

    # ---- what is known ---------------------------------------------------------------------

    @property
    def status(self) -> str:
        """The mission's state in one word; empty if nothing is known."""
        return self.state.status if self.state else ""

    @property
    def explanation(self) -> str:
        """Why it is paused, with the goals that are under way; otherwise the reason."""
        return self.state.explanation if self.state else ""

    @property
    def is_over(self) -> bool:
        """Whether the run with this tree has ended."""
        state, tree = self.state, self.tree
        is_same = state is not None and tree is not None and state.run == tree.run
        return is_same and self.status in FINAL

    @property
    def elapsed_ns(self) -> int:
        """ROS time since the run's start, ns; after its end, up to the end."""
        if self.tree is None:
            return 0
        end_ns = self.state.time_ns if self.is_over and self.state is not None else self.now_ns
        return max(end_ns - self.tree.time_ns, 0)

    def details(self, index: int) -> tuple[str, ...]:
        """Return the details of a node: fields of its goal, conditions, limits, outputs."""
        return () if self.tree is None else self.tree.nodes[index].details

    @property
    def requirements(self) -> tuple[RequirementChanged, ...]:
        """The newest verdict of each requirement; empty if none is known."""
        return tuple(self._requirements.values())

    @property
    def failing(self) -> tuple[RequirementChanged, ...]:
        """Those with which the run does not pass, as far as it is known."""
        return tuple(
            requirement for requirement in self.requirements if requirement.verdict in FAILING
        )

    @property
    def conclusion(self) -> tuple[str, str]:
        """The verdict of a run that has ended, else its state; and :attr:`explanation`."""
        return conclusion(self.status, self.explanation, self.requirements, self.untested)

    @property
    def headline(self) -> str:
        """The same as one text."""
        return verdict(*self.conclusion)

    @property
    def tip(self) -> int | None:
        """The running node without running children that started last."""
        for index in reversed(self.running):
            if not self._running_children[index]:
                return index
        return None

    def children(self, index: int) -> list[int]:
        """The indices of a node's children."""
        assert self.tree is not None, "nodes are those of a tree"
        nodes = self.tree.nodes
        children = []
        for child in range(index + 1, len(nodes)):
            if nodes[child].parent == index:
                children.append(child)
            elif nodes[child].parent < index:
                break
        return children

    def shown(self, index: int, since_ns: int = 0) -> NodeEnd:
        """Return the state of a node in this round: the present one, or its end before a reset.

        py_trees resets nodes that have ended: a fallback that continues with its next child, and a
        halt, reset the earlier ones.

        Args:
            since_ns: The start of the round of the nodes above.
        """
        status, ends = self.statuses[index], self.ends[index]
        if status is Status.INVALID and ends:
            end = ends[-1]
            if end.time_ns is not None and end.time_ns >= since_ns:
                return end
        return NodeEnd(status, self.since_ns[index], self.ran_ns[index], self.messages[index])

    def current(self, index: int) -> NodeEnd:
        """Return the state of a node that views show.

        From the end of the mission on it is how the node ended, in the last round of the nodes
        above it: the halt at the end resets them.
        """
        if self.status in ENDED:
            if self._ended_nodes is None:
                self._ended_nodes = self.shown_nodes()
            return self._ended_nodes[index]
        return NodeEnd(
            self.statuses[index], self.since_ns[index], self.ran_ns[index], self.messages[index]
        )

    @property
    def focus(self) -> int | None:
        """The node at which a breakpoint has paused the mission, else :attr:`tip`."""
        if self.status == "paused" and self.tree is not None and self.state is not None:
            for index, node in enumerate(self.tree.nodes):
                is_set = node.path in self.breakpoints or node.name in self.breakpoints
                is_reached = self.state.reason == AT_BREAKPOINT.format(node.name)
                if is_set and is_reached and self.statuses[index] is not Status.RUNNING:
                    return index
        return self.tip

    def last_end(self, index: int) -> NodeEnd:
        """Return the last end of a node.

        Raises:
            IndexError: It has not ended.
        """
        return self.ends[index][-1]

    def shown_nodes(self) -> list[NodeEnd]:
        """The states of all nodes, each in the round of the nodes above it."""
        assert self.tree is not None, "nodes are those of a tree"
        ends: list[NodeEnd] = []
        rounds: list[int] = []
        for index, node in enumerate(self.tree.nodes):
            above_ns = rounds[node.parent] if index else 0
            ends.append(self.shown(index, above_ns))
            rounds.append(max(above_ns, self._started_ns[index] or 0))
        return ends

    def failure_path(self) -> tuple[int, ...]:
        """The nodes from the root down to the node whose failure was last.

        Empty if the tree has not failed.
        """
        if not self.statuses or self.shown(0).status is not Status.FAILURE:
            return ()
        path, since_ns = [0], 0
        while True:
            since_ns = max(since_ns, self._started_ns[path[-1]] or 0)
            failed = [
                (self.statuses[child] is Status.FAILURE, end.time_ns or 0, child)
                for child in self.children(path[-1])
                if (end := self.shown(child, since_ns)).status is Status.FAILURE
            ]
            if not failed:
                return tuple(path)
            path.append(max(failed)[2])

    # ---- what happens ----------------------------------------------------------------------

    def apply(self, event: Event) -> bool:
        """Apply an event. Return whether it changes the state."""
        self._ended_nodes = None
        is_new = self._APPLY[type(event)](self, event)
        if is_new and (entry := self.entry_of(event)) is not None:
            self.log.append(entry)
        return is_new

    def entry_of(self, event: Event) -> LogEntry | None:
        """Return the line of the log for an event that was applied; None without one.

        Composites follow from their leaves, and events before the viewer attached are in the tree.
        """
        match event:
            case happened.NodeChanged(int() as time_ns, index, status, message):
                return self._node_entry(time_ns, index, status, message)
            case happened.LogLine(time_ns, text):
                return LogEntry(time_ns, None, "", text)
            case RunStarted(time_ns, mission=name):
                return LogEntry(time_ns, None, name, "begins")
            case happened.TreeRevised(time_ns, summary=summary):
                return LogEntry(time_ns, None, "mission revised", summary)
            case happened.StateChanged(time_ns, str(run), _, state) if run:
                return LogEntry(time_ns, None, *mission_state(state, event.explanation))
            case Event(int() as time_ns, event_topic="log"):
                nodes = () if self.tree is None else self.tree.nodes
                return LogEntry(time_ns, None, "", words_of(fields_of(event, nodes)))
        return None

    def _node_entry(
        self, time_ns: int, index: int, status: Status, message: str
    ) -> LogEntry | None:
        if self.tree is None or index >= len(self.is_leaf) or not self.is_leaf[index]:
            return None
        node = self.tree.nodes[index]
        is_reset = status is Status.INVALID and not message
        if node.kind == LOG_KIND or is_reset:
            return None
        return LogEntry(time_ns, status, node.name, "" if status is Status.RUNNING else message)

    def _begin(self, tree: RunStarted) -> bool:
        if self.tree is not None and tree.run == self.tree.run:
            if tree != self.tree:
                self.tree, self.now_ns = tree, max(self.now_ns, tree.time_ns)
            return False
        self.tree, self.now_ns = tree, tree.time_ns
        self._size(tree.nodes)
        self.running, self.progress, self.goals, self.variables = {}, {}, {}, {}
        self.goals_changed_ns, self._ended_goals, self._requirements = {}, {}, {}
        self.ticks = self.goals_sent = None
        self.untested = []
        self.robot.trail.clear()
        return True

    def _revise(self, event: happened.TreeRevised) -> bool:
        """Show another tree; its nodes that the earlier one had keep their state."""
        if self.tree is None or (event.run and event.run != self.tree.run):
            return self._begin(event.as_start())
        self.tree = replace(
            self.tree,
            mission=event.mission,
            nodes=event.nodes,
            revision=event.number,
        )
        known, fresh = len(self.statuses), MissionState()
        before = [index if index < known else -1 for index in event.kept[: len(event.nodes)]]
        fresh._size(event.nodes)
        now = {index: new for new, index in enumerate(before) if index >= 0}
        for name in ("statuses", "messages", "since_ns", "ran_ns", "_started_ns", "ends"):
            values, sized = getattr(self, name), getattr(fresh, name)
            for index, new in now.items():
                sized[new] = values[index]
            setattr(self, name, sized)
        self.is_leaf, self._running_children = fresh.is_leaf, fresh._running_children
        self.running = {now[index]: None for index in self.running if index in now}
        for index in self.running:
            if index:
                self._running_children[event.nodes[index].parent] += 1
        self.progress = {
            now[index]: replace(progress, node=now[index])
            for index, progress in self.progress.items()
            if index in now
        }
        self._see(event.time_ns)
        return True

    def _size(self, nodes: tuple[happened.NodeInfo, ...]) -> None:
        """Make space for the states of these nodes."""
        count = len(nodes)
        self.statuses, self.messages = [Status.INVALID] * count, [""] * count
        self.since_ns, self.ran_ns = [None] * count, [None] * count
        self._started_ns = [None] * count
        self.ends = [()] * count
        self.is_leaf, self._running_children = [True] * count, [0] * count
        for index, node in enumerate(nodes):
            if index:
                self.is_leaf[node.parent] = False

    def _change(self, event: happened.NodeChanged) -> bool:
        """Give a node its status. Without a time only what differs counts as a change."""
        index, time_ns, status = event.node, event.time_ns, event.status
        if index >= len(self.statuses):
            return False
        before = self.statuses[index]
        self.messages[index] = event.message
        if time_ns is None and before is status:
            return False
        since_ns, was_running = self.since_ns[index], before is Status.RUNNING
        if was_running and status is not Status.RUNNING:
            is_known = time_ns is not None and since_ns is not None
            self.ran_ns[index] = time_ns - since_ns if is_known else None  # type: ignore[operator]
        self.statuses[index], self.since_ns[index] = status, time_ns
        self._count_running(index, before, status)
        if status is Status.RUNNING:
            self._started_ns[index] = time_ns
        elif was_running or status is not Status.INVALID:
            end = NodeEnd(status, time_ns, self.ran_ns[index] if was_running else 0, event.message)
            self.ends[index] = (*self.ends[index], end)[-MOST_ENDS:]
        if time_ns is not None:
            self._see(time_ns)
        return True

    def _reset(self, event: happened.NodesReset) -> bool:
        for index in event.nodes:
            if index < len(self.statuses):
                self.statuses[index], self.since_ns[index] = Status.INVALID, None
        self._see(event.time_ns)
        return True

    def _count_running(self, index: int, before: Status, after: Status) -> None:
        assert self.tree is not None
        change = (after is Status.RUNNING) - (before is Status.RUNNING)
        if index:
            self._running_children[self.tree.nodes[index].parent] += change
        self.running.pop(index, None)
        if after is Status.RUNNING:
            self.running[index] = None
        else:
            self.progress.pop(index, None)

    def _progress(self, event: happened.NodeProgressed) -> bool:
        known = self.progress.get(event.node)
        if event.node >= len(self.statuses) or (
            known is not None and replace(known, time_ns=event.time_ns) == event
        ):
            return False
        self.progress[event.node] = event
        self.note_progress(event)
        self._see(event.time_ns)
        return True

    def note_progress(self, event: happened.NodeProgressed) -> None:
        """Note the progress of a running node; progress may arrive before the statuses."""
        if event.node in self.running:
            self.messages[event.node] = event.message
            self.since_ns[event.node] = self._started_ns[event.node] = event.since_ns

    def _goal(self, event: GoalChanged) -> bool:
        known = self.goals.get(event.id)
        if known is None or known.state != event.state:
            self.goals_changed_ns[event.id] = event.time_ns
        elif not event.change:
            return False
        self.goals[event.id] = event
        if event.is_ended:
            self._ended_goals[event.id] = None
        if known is None and len(self.goals) > MOST_GOALS and self._ended_goals:
            self._drop_goal(next(iter(self._ended_goals)))
        self._see(event.time_ns)
        return True

    def _drop_goal(self, goal: str) -> None:
        """Drop a goal that has ended; the tree bounds the number of open ones."""
        del self._ended_goals[goal], self.goals[goal], self.goals_changed_ns[goal]

    def _variable(self, event: happened.VariableChanged) -> bool:
        self._see(event.time_ns)
        if self.variables.get(event.name) == event.value:
            return False
        self.variables[event.name] = event.value
        return True

    def _state(self, event: happened.StateChanged) -> bool:
        if self.state == event:
            return False
        if self.tree is not None and event.run == self.tree.run:
            self._see(event.time_ns)
        self.state = event
        return True

    def _counts(self, event: happened.CountsChanged) -> bool:
        self._see(event.time_ns)
        self.ticks, self.goals_sent = event.ticks, event.goals_sent
        return False

    def _breakpoints(self, event: happened.BreakpointsChanged) -> bool:
        is_new, self.breakpoints = self.breakpoints != event.names, event.names
        return is_new

    def _requirement(self, event: RequirementChanged) -> bool:
        known = self._requirements.get(event.name)
        self._requirements[event.name] = event
        return known is None or replace(known, time_ns=event.time_ns) != event

    def _note_untested(self, event: happened.NotTested) -> bool:
        self.untested.append(event.what)
        return self._other(event)

    def _other(self, event: Event) -> bool:
        if event.time_ns is not None and event.time_ns > self.now_ns:
            self.now_ns = event.time_ns
        return True

    def _see(self, time_ns: int) -> None:
        self.now_ns = max(self.now_ns, time_ns)

    _APPLY: ClassVar[Mapping[type, Callable[..., bool]]] = defaultdict(
        lambda: MissionState._other,
        {
            happened.RunStarted: _begin,
            happened.TreeRevised: _revise,
            happened.NodeChanged: _change,
            happened.NodesReset: _reset,
            happened.NodeProgressed: _progress,
            happened.GoalChanged: _goal,
            happened.VariableChanged: _variable,
            happened.StateChanged: _state,
            happened.CountsChanged: _counts,
            happened.BreakpointsChanged: _breakpoints,
            happened.RequirementChanged: _requirement,
            happened.NotTested: _note_untested,
        },
    )
    """The change by each event, besides the time; other events only have a line in the log."""


def _copied(state: State) -> State:
    """Return a copy with separate containers; their items are frozen."""
    other = copy.copy(state)
    for name, value in vars(state).items():
        if isinstance(value, list | dict | deque):
            setattr(other, name, value.copy())
    return other
