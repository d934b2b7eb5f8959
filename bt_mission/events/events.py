"""What happens in a mission that is watched, one thing at a time."""

from __future__ import annotations

from dataclasses import dataclass

from py_trees.common import Status

from bt_mission.events import messages


@dataclass(frozen=True)
class Began:
    """A mission has started, or has been found."""

    tree: messages.Tree


@dataclass(frozen=True)
class Changed:
    """A node has another status. The time is None where only the present is known."""

    time_ns: int | None
    index: int
    node: messages.Node
    status: Status
    message: str
    is_leaf: bool


@dataclass(frozen=True)
class Progressed:
    """A running node has come further."""

    time_ns: int
    node: messages.Node
    progress: messages.Progress


@dataclass(frozen=True)
class Stood:
    """The mission's state is another one."""

    state: messages.State


@dataclass(frozen=True)
class GoalMoved:
    """A goal was sent, or its state is another one."""

    goal: messages.Goal


@dataclass(frozen=True)
class Assigned:
    """A variable has a value, as JSON."""

    time_ns: int
    name: str
    value: str


@dataclass(frozen=True)
class Spoke:
    """The mission says a line."""

    time_ns: int
    text: str


Happening = Began | Changed | Progressed | Stood | GoalMoved | Assigned | Spoke
