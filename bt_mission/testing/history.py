"""Everything that happened in a run, written down as it happens, to be asked about later.

Writing down must cost little, since every control step does it; what is dear (the tree as text,
a clearance) is worked out when somebody asks.
"""

from __future__ import annotations

import json
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.base.stamps import NS
from bt_mission.base.text import escape_control, seconds
from bt_mission.executive.events.events import Event, GoalChanged, NodeChanged, TreeRevised
from bt_mission.executive.events.goal_life import GoalLife
from bt_mission.executive.events.log import UNICODE, line_of
from bt_mission.sessions.stage import Stage
from bt_mission.testing.errors import RunVariables

Pose = tuple[float, float, float]
"""x m, y m, yaw rad."""

ENDS = (Status.SUCCESS, Status.FAILURE)


@dataclass(eq=False)
class TestedGoal(GoalLife):
    """One goal of a test's run; its changes have the time since the start."""

    __test__ = False

    @property
    def sent_s(self) -> float:
        """When it was sent, s since the start."""
        return self.changes[0][0] / NS

    @property
    def ended_s(self) -> float | None:
        """When its end was confirmed; None while it has not been."""
        ended_ns = self.change_ns("ended")
        return None if ended_ns is None else ended_ns / NS

    @property
    def status(self) -> str | None:
        """The status of its result; None without one."""
        newest = self.changes[-1][1]
        return newest.state if newest.is_ended and newest.state != "rejected" else None

    def __str__(self) -> str:
        lives = ", ".join(
            f"{event.change} at {seconds(time_ns / NS)}" for time_ns, event in self.changes
        )
        end = f": {self.status}" if self.status else ""
        return f"{self.action} goal {self.id[:8]} of '{self.owner}' ({lives}){end}"


class Recorded:
    """Messages of a topic with the virtual times at which they came.

    Args:
        name: Resolved name of the topic.
        stage: Provides the time.
    """

    def __init__(self, name: str, stage: Stage) -> None:
        self.name = name
        self._stage = stage
        self._times_ns: list[int] = []
        self._messages: list[Any] = []

    def add(self, message: Any) -> None:
        """Write a message down that comes now."""
        self._times_ns.append(self._stage.now_ns)
        self._messages.append(message)

    @property
    def messages(self) -> tuple[Any, ...]:
        """All of them, in order."""
        return tuple(self._messages)

    @property
    def times(self) -> tuple[float, ...]:
        """When each came, s since the start of the run."""
        return tuple((time_ns - self._stage.start_ns) / 1e9 for time_ns in self._times_ns)

    @property
    def last(self) -> Any:
        """The newest; None before the first."""
        return self._messages[-1] if self._messages else None

    def at(self, time_ns: int) -> Any:
        """The newest at a virtual time; None before the first."""
        number = bisect_right(self._times_ns, time_ns)
        return self._messages[number - 1] if number else None

    def __len__(self) -> int:
        return len(self._messages)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._messages)


class History:
    """Listens to a stage from its beginning."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self.start_ns = stage.start_ns
        self.nodes = stage.executive.nodes
        self._indices = stage.executive.indices
        self.paths = {node: stage.executive.path_of(node) for node in self.nodes}
        self.changes: list[NodeChanged] = []
        self.goals: dict[str, TestedGoal] = {}
        self.goal_changes: list[tuple[str, TestedGoal]] = []
        self.logged_lines: list[tuple[float, str]] = []
        self.events: list[str] = list(stage.trace.newest)
        self._changes_of: defaultdict[int, list[int]] = defaultdict(list)
        self._variables: Mapping[str, Any] = MappingProxyType(RunVariables())
        stage.executive.events.subscribe(self._take)
        stage.trace.lines.subscribe(self.events.append)

    def seconds(self, time_ns: int) -> float:
        """Virtual time since the start, s."""
        return (time_ns - self.start_ns) / NS

    def variables(self) -> Mapping[str, Any]:
        """Return the mission's variables as they are now, however they change later."""
        values = self._stage.runner.scope.values
        if values != self._variables:
            self._variables = MappingProxyType(RunVariables(values))
        return self._variables

    def say(self, text: str) -> None:
        """Write down what the mission says."""
        self.logged_lines.append((self.seconds(self._stage.now_ns), text))

    @cached_property
    def review(self) -> Any:
        """Reads recorded states of the simulation; created at first use."""
        return self._stage.runs[0].robot.review()

    # ---- asking --------------------------------------------------------------------------

    def last_change(self, node: Behaviour, changes: int) -> NodeChanged | None:
        """The newest change of this node among the first `changes`."""
        numbers = self._changes_of[self._indices[node]]
        at = bisect_right(numbers, changes - 1)
        return self.changes[numbers[at - 1]] if at else None

    def count(self, node: Behaviour, changes: int, *statuses: Status) -> int:
        """How often the node came into one of these statuses."""
        numbers = self._changes_of[self._indices[node]]
        at = bisect_right(numbers, changes - 1)
        return sum(self.changes[number].status in statuses for number in numbers[:at])

    def failed_path(self) -> tuple[Behaviour, ...]:
        """Return the nodes from the root down that have failed, each because of the next."""
        return tuple(
            self.nodes[index] for index in self._stage.executive.mission_state.failure_path()
        )

    def tree_text(self, changes: int) -> str:
        """The tree after the first `changes`: a line for each node, with its message at the end."""
        lines = []
        for node in self.nodes:
            change = self.last_change(node, changes)
            status = change.status if change else Status.INVALID
            depth = self.paths[node].count(".")
            message = f"  {change.message}" if change and status in ENDS and change.message else ""
            lines.append(escape_control(f"{'  ' * depth}{UNICODE[status]} {node.name}{message}"))
        return "\n".join(lines)

    def read_events(self) -> Iterator[dict[str, Any]]:
        """Every event of the trace."""
        yield from map(json.loads, self.events)

    def last_events(self, most: int) -> list[str]:
        """The newest events of the trace except poses, as text."""
        events = [event for event in self.read_events() if event.get("event", "pose") != "pose"]
        return [
            f"{seconds(self.seconds(event['t'])):>10}  {line_of(event)}" for event in events[-most:]
        ]

    # ---- listening -----------------------------------------------------------------------

    def _take(self, event: Event) -> None:
        match event:
            case TreeRevised(kept=kept):
                executive, before = self._stage.executive, self._changes_of
                self.nodes, self._indices = executive.nodes, executive.indices
                self.paths = {node: executive.path_of(node) for node in self.nodes}
                self._changes_of = defaultdict(
                    list, {new: before[index] for new, index in enumerate(kept) if index in before}
                )
            case NodeChanged(node=node):
                self._changes_of[node].append(len(self.changes))
                self.changes.append(event)
            case GoalChanged(change=change) if change:
                self._take_goal(event)

    def _take_goal(self, event: GoalChanged) -> None:
        life = self.goals.setdefault(event.id, TestedGoal(event.id, event.action, event.owner))
        life.take(event, event.time_ns - self.start_ns)
        self.goal_changes.append((event.change, life))
