"""What happens in a mission that is watched, one thing at a time."""

from __future__ import annotations

from dataclasses import dataclass

from py_trees.common import Status

from bt_mission.events import messages


@dataclass(frozen=True)
class MissionStarted:
    """A mission has started, or has been found."""

    tree: messages.TreeInfo


@dataclass(frozen=True)
class NodeStatusChanged:
    """A node has another status. The time is None where only the present is known."""

    time_ns: int | None
    index: int
    node: messages.NodeInfo
    status: Status
    message: str
    is_leaf: bool


@dataclass(frozen=True)
class NodeProgressed:
    """A running node has come further."""

    time_ns: int
    node: messages.NodeInfo
    progress: messages.NodeProgress


@dataclass(frozen=True)
class MissionStateChanged:
    """The mission's state is another one."""

    state: messages.MissionStateInfo


@dataclass(frozen=True)
class GoalChanged:
    """A goal was sent, or its state is another one."""

    goal: messages.GoalInfo


@dataclass(frozen=True)
class VariableChanged:
    """A variable has a value, as JSON."""

    time_ns: int
    name: str
    value: str


@dataclass(frozen=True)
class LogLine:
    """The mission says a line."""

    time_ns: int
    text: str


MissionEvent = (
    MissionStarted
    | NodeStatusChanged
    | NodeProgressed
    | MissionStateChanged
    | GoalChanged
    | VariableChanged
    | LogLine
)
