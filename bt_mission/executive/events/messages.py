"""Messages of an executive and of a robot, as plain data.

Times are ROS time, ns.
"""

from __future__ import annotations

from dataclasses import dataclass

from bt_mission.executive.events.events import Event
from bt_mission.executive.events.mission_file import MissionOrigin


@dataclass(frozen=True, slots=True)
class Batch:
    """Events of one run that an executive has sent together.

    Attributes:
        run: Identifies the run; empty before the first run.
        sequence: The number of a message with changes of nodes, from 1; 0 for others.
        is_complete: Whether these are the statuses of all nodes, with all changes up to the
            sequence.
        revision: The number of revisions that led to the tree to which the indices refer.
        file: The file of the mission, with a tree.
    """

    run: str
    events: tuple[Event, ...]
    sequence: int = 0
    is_complete: bool = False
    revision: int = 0
    file: MissionOrigin | None = None


@dataclass(frozen=True)
class FrameTransform:
    """The pose of a frame in its parent, on the floor: m, m, rad."""

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
    """The pose of another robot on the map: m, m, rad."""

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
"""A message of a robot."""

ROBOT = (tuple, ScanPoints, Map, Zones, BatteryState, OtherRobot)
"""The classes of :data:`Robot`."""
