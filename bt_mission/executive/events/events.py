"""What happens in a mission: a closed set of events.

The executive emits them; a trace, topics, recordings, journals, views and requirements take them.
Nodes are given by their index in the tree, depth first. Times are ROS time, ns; statuses are those
of py_trees.

A new event is a class here. Its fields are plain values, a field ``node`` is a node's index; lines
of JSON, messages and words follow from them. What it changes is added to
:mod:`bt_mission.executive.events.mission_state`, words of its own to
:mod:`bt_mission.executive.events.log`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from py_trees.common import Status

from bt_mission.executive.goals.poses import NamedPose
from bt_mission.executive.listeners import Stream

FINAL = ("success", "failure", "interrupted")
"""Values of :attr:`StateChanged.status` of a mission that has ended."""

ENDED = ("ending", "observing", *FINAL)
"""The same of a mission whose tree is not ticked any more."""

AT_BREAKPOINT = "breakpoint at '{}'"
"""The reason of a pause before a node, by the node's name."""

OPEN = ("sent", "recalled", "active", "canceling")
"""Values of :attr:`GoalChanged.state` of a goal that its server may still work on."""


@dataclass(frozen=True, slots=True)
class NodeInfo:
    """A node of a tree.

    Attributes:
        kind: The class of its behaviour.
        path: Its path: ``0`` is the root, ``0.2`` the root's third child.
        parent: The index of its parent; for the root, its own index.
        details: What it does, as its author wrote it, a line each.
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
class Event:
    """An event of a mission.

    Attributes:
        event_name: Its name in lines of JSON.
        is_traced: Whether it follows from mission and seed alone, so that traces and recordings
            have it.
        event_topic: Its topic below the name of the executive; ``log`` carries any event, empty is
            no topic.
    """

    event_name: ClassVar[str]
    is_traced: ClassVar[bool] = True
    event_topic: ClassVar[str] = "log"

    time_ns: int | None

    def __init_subclass__(cls) -> None:
        KINDS[cls.event_name] = cls


KINDS: dict[str, type[Event]] = {}
"""The classes of events, by their names in lines of JSON."""


@dataclass(frozen=True, slots=True)
class RunStarted(Event):
    """A mission has started with this tree, or was already running.

    Attributes:
        run: Identifies the run.
        nodes: Nodes, depth first.
        world: None without a simulation, and if it is not known.
        revision: The number of revisions that led to this tree.
    """

    event_name = "start"
    event_topic = "tree"

    time_ns: int
    run: str
    mission: str
    nodes: tuple[NodeInfo, ...]
    world: str | None = None
    robot: str = ""
    seed: int = 0
    revision: int = 0


@dataclass(frozen=True, slots=True)
class TreeRevised(Event):
    """The running mission is another version of itself from now on, with this tree.

    Attributes:
        run: Identifies the run, which continues.
        nodes: Nodes, depth first.
        kept: For each of them, its index in the tree before; -1 for a new one.
        number: 1 for the first revision of a run.
        summary: What has changed, as text.
        start_ns: ROS time of the start of the run, ns.
        cycle: The number of cycles of the executive before it; 0 if it is not known.
        keep_goals: Leaves that ran and have changed continue with their earlier values.
    """

    event_name = "revised"
    event_topic = "tree"

    time_ns: int
    run: str
    mission: str
    nodes: tuple[NodeInfo, ...]
    kept: tuple[int, ...]
    number: int
    summary: str = ""
    start_ns: int = 0
    cycle: int = 0
    keep_goals: bool = False

    def as_start(self) -> RunStarted:
        """Return the tree as that of a run that was already running."""
        start_ns = self.start_ns or self.time_ns
        return RunStarted(start_ns, self.run, self.mission, self.nodes, revision=self.number)


@dataclass(frozen=True, slots=True)
class NodeChanged(Event):
    """A node has another status. The time is None if only the present status is known."""

    event_name = "status"
    event_topic = "changes"

    time_ns: int | None
    node: int
    status: Status
    message: str


@dataclass(frozen=True, slots=True)
class NodesReset(Event):
    """A new round of a loop, or a halt, has taken back the status of nodes that had ended."""

    event_name = "reset"
    event_topic = "changes"

    time_ns: int
    nodes: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class NodeProgressed(Event):
    """A running node has made progress; ``limit`` is 0 without a measure."""

    event_name = "progress"
    is_traced = False
    event_topic = "details"

    time_ns: int
    node: int
    since_ns: int
    message: str
    label: str
    value: float
    limit: float


@dataclass(frozen=True, slots=True)
class GoalChanged(Event):
    """A goal was sent, or has another state.

    Attributes:
        id: UUID, 32 hexadecimal digits.
        owner: The name of the leaf that sent it.
        change: The change by the ledger: sent, found again, released, abandoned, ended; empty if
            only the state is another one.
        targets: The poses to which it sends the robot.
    """

    event_name = "goal"
    event_topic = "details"

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
        """Whether its server has confirmed its end."""
        return self.state not in (*OPEN, "lost")


@dataclass(frozen=True, slots=True)
class VariableChanged(Event):
    """A variable has a value, as JSON."""

    event_name = "variable"
    is_traced = False
    event_topic = "details"

    time_ns: int
    name: str
    value: str


@dataclass(frozen=True, slots=True)
class StateChanged(Event):
    """The mission's state.

    It is idle, recovering, running, paused, ending, observing, or one of :data:`FINAL`.

    Attributes:
        reason: Why it is paused, observed or ended.
        under_way: While it is paused, the goals that are under way.
        keep_goals: Of a pause: whether goals keep running.
        verdict: Of an observation: the verdict of the mission.
        observe_s: The time for which it is observed, s.
        is_update: Whether only `under_way` has changed.
    """

    event_name = "mission"
    event_topic = "state"

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
        """The reason as text, with the goals under way, and the time of the observation."""
        if self.status == "observing":
            reason = ": ".join(filter(None, (self.verdict, self.reason)))
            return f"{reason}; observing for {self.observe_s:g} s" if self.verdict else reason
        under_way = ", ".join(self.under_way)
        return self.reason + (f"; still running: {under_way}" if under_way else "")


@dataclass(frozen=True, slots=True)
class CountsChanged(Event):
    """The numbers of ticks and of goals sent."""

    event_name = "counts"
    is_traced = False
    event_topic = "details"

    time_ns: int
    ticks: int
    goals_sent: int


@dataclass(frozen=True, slots=True)
class BreakpointsChanged(Event):
    """The nodes with breakpoints are these, by name or path."""

    event_name = "breakpoints"
    is_traced = False
    event_topic = "details"

    time_ns: int
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class LogLine(Event):
    """The mission logs a line.

    Attributes:
        is_own: Whether a leaf logs it. Otherwise it describes another event.
    """

    event_name = "log"

    time_ns: int
    text: str
    is_own: bool = True


@dataclass(frozen=True, slots=True)
class RequirementChanged(Event):
    """A requirement has another verdict or margin.

    Attributes:
        verdict: ``holds``, ``violated``, ``open`` or ``unknown``.
        margin: By how much it holds so far, negative if it is violated; None without a measure.
        at: The instant that decides the margin, s since the start.
        outcome: The whole result as text.
        is_update: Whether only its margin has changed.
    """

    event_name = "requirement"
    event_topic = "requirements"

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
class ClockJumped(Event):
    """The ROS clock has jumped by this, s: below 0 it was set back."""

    event_name = "clock"

    time_ns: int
    jump: float


@dataclass(frozen=True, slots=True)
class FaultChanged(Event):
    """An injected fault begins or ends."""

    event_name = "fault"

    time_ns: int
    number: int
    what: str
    state: str
    parameters: Mapping[str, Any] | None = field(default=None, hash=False)


@dataclass(frozen=True, slots=True)
class NotTested(Event):
    """The run ends, and something that was planned for it has not happened."""

    event_name = "untested"

    time_ns: int
    what: str


@dataclass(frozen=True, slots=True)
class PoseSampled(Event):
    """The robot's true pose in the simulation (m, m, rad), and its collisions so far."""

    event_name = "pose"
    event_topic = ""

    time_ns: int
    x: float
    y: float
    yaw: float
    collisions: int


EventStream = Stream[Event]
