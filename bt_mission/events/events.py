"""What happens in a mission that is watched, one thing at a time.

Times are ROS time, ns. Statuses are those of py_trees.
"""

from __future__ import annotations

from dataclasses import dataclass

from py_trees.common import Status

FINAL = ("success", "failure", "interrupted")
"""Words of :attr:`MissionStateChanged.status` that are said of a mission that has ended."""

OPEN = ("sent", "recalled", "active", "canceling")
"""Words of :attr:`GoalChanged.state` that are said of a goal that may still be worked on."""


@dataclass(frozen=True)
class NodeInfo:
    """A node of a tree; ``parent`` is its parent's index, the root's is its own."""

    name: str
    kind: str
    path: str
    parent: int

    @property
    def depth(self) -> int:
        """0 for the root."""
        return self.path.count(".")


@dataclass(frozen=True)
class MissionStarted:
    """A mission has started, or has been found, with this tree: its nodes, depth first."""

    time_ns: int
    run: str
    mission: str
    nodes: tuple[NodeInfo, ...]


@dataclass(frozen=True)
class NodeStatusChanged:
    """A node has another status. The time is None where only the present is known."""

    time_ns: int | None
    index: int
    node: NodeInfo
    status: Status
    message: str
    is_leaf: bool


@dataclass(frozen=True)
class NodeProgress:
    """What a running node does; ``limit`` is 0 where nothing is measured."""

    node: int
    since_ns: int
    message: str
    label: str
    value: float
    limit: float


@dataclass(frozen=True)
class NodeProgressed:
    """A running node has come further."""

    time_ns: int
    node: NodeInfo
    progress: NodeProgress


@dataclass(frozen=True)
class MissionStateChanged:
    """Where a mission stands: idle, running, paused, ending, observing, or one of :data:`FINAL`."""

    time_ns: int
    run: str
    mission: str
    status: str
    reason: str


@dataclass(frozen=True)
class GoalChanged:
    """A goal was sent, or its state is another one; ``targets`` are places on the map, m."""

    id: str
    action: str
    owner: str
    sent_ns: int
    changed_ns: int
    state: str
    targets: tuple[tuple[float, float], ...] = ()


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
    run: str
    text: str


@dataclass(frozen=True)
class RequirementChanged:
    """A requirement has come to something else.

    Attributes:
        verdict: ``holds``, ``violated``, ``open`` or ``unknown``.
        margin: By how much it holds so far, below 0 by how much it is violated; None where it has
            no measure.
        at: The instant that decides the margin, s since the start.
        outcome: All of it in words.
    """

    time_ns: int
    run: str
    name: str
    requirement: str
    verdict: str
    margin: float | None
    unit: str
    at: float | None
    violated_at: float | None
    on_violation: str
    sources: tuple[str, ...]
    why: str
    outcome: str


MissionEvent = (
    MissionStarted
    | NodeStatusChanged
    | NodeProgressed
    | MissionStateChanged
    | GoalChanged
    | VariableChanged
    | LogLine
    | RequirementChanged
)
