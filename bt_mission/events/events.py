"""What happens in a mission: a closed set of events.

The executive emits them; a trace, topics, recordings, journals, views and requirements take them.
Nodes are given by their index in the tree, depth first. Times are ROS time, ns; statuses are those
of py_trees.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from py_trees.common import Status

from bt_mission.core.listeners import Stream
from bt_mission.goals.poses import NamedPose

FINAL = ("success", "failure", "interrupted")
"""Values of :attr:`StateChanged.status` of a mission that has ended."""

OPEN = ("sent", "recalled", "active", "canceling")
"""Values of :attr:`GoalChanged.state` of a goal that its server may still work on."""


@dataclass(frozen=True, slots=True)
class NodeInfo:
    """A node of a tree.

    Attributes:
        kind: Class of its behaviour.
        path: Its place: ``0`` is the root, ``0.2`` the root's third child.
        parent: Its parent's index; the root's is its own.
        details: What it is asked to do, in its author's words, a line each.
    """

    name: str
    kind: str
    path: str
    parent: int
    details: tuple[str, ...] = ()

    @property
    def depth(self) -> int:
        """0 for the root."""
        return self.path.count(".")


@dataclass(frozen=True, slots=True)
class RunStarted:
    """A mission has started with this tree, or was found running.

    Attributes:
        run: Identifies the run.
        nodes: Depth first.
        world: None where there is no simulation, and where it is not known.
    """

    time_ns: int
    run: str
    mission: str
    nodes: tuple[NodeInfo, ...]
    world: str | None = None
    robot: str = ""
    seed: int = 0


@dataclass(frozen=True, slots=True)
class NodeChanged:
    """A node has another status. The time is None where only the present one is known."""

    time_ns: int | None
    node: int
    status: Status
    message: str


@dataclass(frozen=True, slots=True)
class NodesReset:
    """A new round of a loop, or a halt, has taken back the status of nodes that had ended."""

    time_ns: int
    nodes: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class NodeProgressed:
    """A running node has made progress; ``limit`` is 0 where nothing is measured."""

    time_ns: int
    node: int
    since_ns: int
    message: str
    label: str
    value: float
    limit: float


@dataclass(frozen=True, slots=True)
class GoalChanged:
    """A goal was sent, or has another state.

    Attributes:
        id: UUID, 32 hexadecimal digits.
        owner: Name of the leaf that sent it.
        change: What the ledger did: sent, found again, released, abandoned, ended; empty where
            only the state is another one.
        targets: The places where it sends the robot.
    """

    time_ns: int
    id: str
    action: str
    owner: str
    sent_ns: int
    state: str
    change: str = ""
    targets: tuple[NamedPose, ...] = ()

    @property
    def is_ended(self) -> bool:
        """Has its server confirmed that it has ended?"""
        return self.state not in (*OPEN, "lost")


@dataclass(frozen=True, slots=True)
class VariableChanged:
    """A variable has a value, as JSON."""

    time_ns: int
    name: str
    value: str


@dataclass(frozen=True, slots=True)
class StateChanged:
    """The mission's state: idle, running, paused, ending, observing, or one of :data:`FINAL`.

    Attributes:
        reason: Why it is paused, observed or over.
        under_way: While it is paused, the goals that are still under way.
        keep_goals: Of a pause: do goals run on?
        verdict: Of an observation: how the mission has ended.
        observe_s: How long it is observed, s.
        is_update: Is only what is under way another one?
    """

    time_ns: int
    run: str
    mission: str
    status: str
    reason: str
    under_way: tuple[str, ...] = ()
    keep_goals: bool = False
    verdict: str = ""
    observe_s: float = 0.0
    is_update: bool = False

    @property
    def explanation(self) -> str:
        """The reason in words, with the goals under way, and how long it is observed."""
        if self.status == "observing":
            reason = ": ".join(filter(None, (self.verdict, self.reason)))
            return f"{reason}; observing for {self.observe_s:g} s" if self.verdict else reason
        under_way = ", ".join(self.under_way)
        return self.reason + (f"; still under way: {under_way}" if under_way else "")


@dataclass(frozen=True, slots=True)
class CountsChanged:
    """How often the tree was ticked, and how many goals were sent."""

    time_ns: int
    ticks: int
    goals_sent: int


@dataclass(frozen=True, slots=True)
class BreakpointsChanged:
    """The nodes with breakpoints are these, by name or path."""

    time_ns: int
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class LogLine:
    """The mission says a line.

    Attributes:
        is_own: Does a leaf say it? Else it repeats another event in words, for people.
    """

    time_ns: int
    text: str
    is_own: bool = True


@dataclass(frozen=True, slots=True)
class RequirementChanged:
    """A requirement has another verdict or margin.

    Attributes:
        verdict: ``holds``, ``violated``, ``open`` or ``unknown``.
        margin: By how much it holds so far, below 0 by how much it is violated; None where it has
            no measure.
        at: The instant that decides the margin, s since the start.
        outcome: All of it in words.
        is_update: Is only its margin another one?
    """

    time_ns: int
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
    is_update: bool = False


@dataclass(frozen=True, slots=True)
class ClockJumped:
    """The ROS clock was set back (below 0) or skipped time, s."""

    time_ns: int
    jump_s: float


@dataclass(frozen=True, slots=True)
class FaultChanged:
    """An injected fault begins or ends."""

    time_ns: int
    number: int
    what: str
    state: str
    parameters: Mapping[str, Any] | None = field(default=None, hash=False)


@dataclass(frozen=True, slots=True)
class PoseSampled:
    """The robot's true pose in the simulation (m, m, rad), and its collisions so far."""

    time_ns: int
    x: float
    y: float
    yaw: float
    collisions: int


Event = (
    RunStarted
    | NodeChanged
    | NodesReset
    | NodeProgressed
    | GoalChanged
    | VariableChanged
    | StateChanged
    | CountsChanged
    | BreakpointsChanged
    | LogLine
    | RequirementChanged
    | ClockJumped
    | FaultChanged
    | PoseSampled
)

EventStream = Stream[Event]
