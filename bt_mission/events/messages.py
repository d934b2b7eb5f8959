"""What an executive tells of a mission, and a robot of itself, as plain data.

Times are ROS time, ns. Statuses are those of py_trees.
"""

from __future__ import annotations

from dataclasses import dataclass

from py_trees.common import Status

FINAL = ("success", "failure", "interrupted")
"""Words of :attr:`MissionStateInfo.status` that are said of a mission that has ended."""

OPEN = ("sent", "recalled", "active", "canceling")
"""Words of :attr:`GoalInfo.state` that are said of a goal that may still be worked on."""


@dataclass(frozen=True)
class NodeInfo:
    """A node of a tree; ``parent`` is its parent's index, the root's is its own."""

    name: str
    kind: str
    path: str
    parent: int


@dataclass(frozen=True)
class TreeInfo:
    """The tree of a mission that has started, depth first."""

    time_ns: int
    run: str
    mission: str
    nodes: tuple[NodeInfo, ...]


@dataclass(frozen=True)
class NodeStatus:
    """The status of the node with this index, and what the node says about it."""

    node: int
    status: Status
    message: str


@dataclass(frozen=True)
class Changes:
    """What one tick has changed; sequence 1 is the first of a run."""

    time_ns: int
    run: str
    sequence: int
    changes: tuple[NodeStatus, ...]


@dataclass(frozen=True)
class Statuses:
    """The status of every node, with all changes up to a sequence number."""

    run: str
    sequence: int
    statuses: tuple[NodeStatus, ...]


@dataclass(frozen=True)
class MissionStateInfo:
    """Where a mission stands: idle, running, paused, ending, or one of :data:`FINAL`."""

    time_ns: int
    run: str
    mission: str
    status: str
    reason: str


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
class GoalInfo:
    """A goal that a mission has sent; ``targets`` are places on the map, m."""

    id: str
    action: str
    owner: str
    sent_ns: int
    changed_ns: int
    state: str
    targets: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True)
class DetailsUpdate:
    """What a mission is doing. Goals and variables are those that have changed, or all."""

    time_ns: int
    run: str
    ticks: int
    goals_sent: int
    running: tuple[NodeProgress, ...]
    goals: tuple[GoalInfo, ...]
    variables: tuple[tuple[str, str], ...]
    breakpoints: tuple[str, ...]


@dataclass(frozen=True)
class LogText:
    """A line that a mission says."""

    time_ns: int
    run: str
    text: str


@dataclass(frozen=True)
class FrameTransform:
    """Where a frame is in its parent, on the floor: m, m, rad."""

    parent: str
    child: str
    x: float
    y: float
    yaw: float


@dataclass(frozen=True)
class ScanPoints:
    """A lidar's scan: each ray's angle (rad, from the frame's x axis) and range (m)."""

    frame: str
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    ranges: tuple[float, ...]


@dataclass(frozen=True)
class Map:
    """An occupancy grid: ``cells`` row by row from its origin (m), -1 unknown, 0 to 100 occupied.

    A byte of ``cells`` is a signed one. The grid may be turned by ``yaw`` about its origin.
    """

    resolution: float
    width: int
    height: int
    x: float
    y: float
    yaw: float
    cells: bytes


@dataclass(frozen=True)
class BatteryState:
    """A battery's charge and its voltage, V; either may be nan.

    The charge is 0 to 1 by the message's definition, and 0 to 100 on a TurtleBot3.
    """

    charge: float
    voltage: float


Told = TreeInfo | Changes | Statuses | MissionStateInfo | DetailsUpdate | LogText
"""What comes from an executive."""

Robot = tuple[FrameTransform, ...] | ScanPoints | Map | BatteryState
"""What comes from a robot."""
