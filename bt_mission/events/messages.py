"""How an executive tells of a mission, and a robot of itself, as plain data.

Some messages are events of :mod:`bt_mission.events.events` as they are; others hold several.

Times are ROS time, ns. Statuses are those of py_trees.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from py_trees.common import Status

from bt_mission.events.events import (
    FINAL,
    GoalChanged,
    LogLine,
    MissionStarted,
    MissionStateChanged,
    NodeProgress,
    RequirementChanged,
)


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
class DetailsUpdate:
    """What a mission is doing. Goals and variables are those that have changed, or all."""

    time_ns: int
    run: str
    ticks: int
    goals_sent: int | None
    """None where nobody tells of goals."""
    running: tuple[NodeProgress, ...]
    goals: tuple[GoalChanged, ...]
    variables: tuple[tuple[str, str], ...]
    breakpoints: tuple[str, ...]


@dataclass(frozen=True)
class NodeDetails:
    """What the nodes of a run are asked to do, in their author's words, by the nodes' paths."""

    run: str
    nodes: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True)
class Requirements:
    """What all requirements of a run have come to."""

    time_ns: int
    run: str
    requirements: tuple[RequirementChanged, ...]


Told = (
    MissionStarted
    | NodeDetails
    | Requirements
    | Changes
    | Statuses
    | MissionStateChanged
    | DetailsUpdate
    | LogLine
)
"""What comes from an executive."""


def in_order(told: Iterable[Told]) -> list[Told]:
    """Put the end of a mission after all else that is told of it; topics may overtake."""
    ordered = list(told)
    for one in tuple(ordered):
        if isinstance(one, MissionStateChanged) and one.status in FINAL:
            last = max(at for at, other in enumerate(ordered) if other.run == one.run)
            ordered.insert(last + 1, one)
            ordered.remove(one)
    return ordered


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


@dataclass(frozen=True)
class CameraImage:
    """A picture: its pixels row by row, ``step`` bytes a row, in an encoding of ``sensor_msgs``."""

    width: int
    height: int
    step: int
    encoding: str
    data: bytes


@dataclass(frozen=True, slots=True)
class OtherRobot:
    """Where another robot is on the map: m, m, rad."""

    name: str
    x: float
    y: float
    yaw: float


@dataclass(frozen=True, slots=True)
class ZoneDisc:
    """A zone of a world: its name, its middle and radius on the map, m, and its colour #rrggbb."""

    name: str
    x: float
    y: float
    radius: float
    colour: str


@dataclass(frozen=True)
class Zones:
    """All zones of a world."""

    zones: tuple[ZoneDisc, ...]


Robot = tuple[FrameTransform, ...] | ScanPoints | Map | Zones | BatteryState | OtherRobot
"""What comes from a robot."""
