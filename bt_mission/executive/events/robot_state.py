"""The state of a robot: its pose and trail, lidar, map and battery."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Iterable

from bt_mission.base.geometry import Pose2D, composed
from bt_mission.executive.events import messages

BASES = ("base_footprint", "base_link")
"""Frames of a robot's base, the best first; also with a prefix before a slash."""

TRAIL_STEP_M = 0.05
"""The distance between two poses of the trail, m."""

TRAIL_POINTS = 5_000
MAP_FRAME = "map"
FRAME_LEVELS = 50
"""The most frames between the root and a sensor; more are a cycle."""


Frames = dict[str, tuple[str, Pose2D]]
"""The parent of each frame, and its pose there."""


def frames_of(transforms: Iterable[messages.FrameTransform]) -> Frames:
    """Return the frames of transforms."""
    return {
        transform.child: (transform.parent, Pose2D(transform.x, transform.y, transform.yaw))
        for transform in transforms
    }


def locate(frames: Frames, frame: str, roots: Collection[str] = ()) -> tuple[str, Pose2D]:
    """Return the root above a frame, or the first of ``roots``, and where the frame is in it."""
    pose = Pose2D(0.0, 0.0, 0.0)
    for _ in range(FRAME_LEVELS):
        if frame not in frames or frame in roots:
            break
        frame, step = frames[frame]
        pose = composed(step, pose)
    return frame, pose


class RobotState:
    """The state of a robot, from its messages. Feed it with :meth:`take`."""

    def __init__(self) -> None:
        self.map: messages.Map | None = None
        self.zones: tuple[messages.ZoneDisc, ...] = ()
        self.scan: messages.ScanPoints | None = None
        self.battery: messages.BatteryState | None = None
        self.trail: deque[tuple[float, float]] = deque(maxlen=TRAIL_POINTS)
        self.others: dict[str, Pose2D] = {}
        """The poses of other robots on the map, by name."""
        self.frame = ""
        """The frame that pose and trail are in: ``map``, or ``odom`` where nobody localises."""
        self._frames: Frames = {}
        self._is_percent = False

    def take(self, reading: messages.Robot) -> None:
        """Apply a message of the robot."""
        match reading:
            case messages.ScanPoints():
                self.scan = reading
            case messages.Map():
                self.map = reading
            case messages.Zones():
                self.zones = reading.zones
            case messages.BatteryState():
                self.battery = reading
                self._is_percent |= reading.charge > 1
            case messages.OtherRobot():
                self.others[reading.name] = Pose2D(reading.x, reading.y, reading.yaw)
            case transforms:
                self._frames |= frames_of(transforms)
                self._extend_trail()

    @property
    def charge(self) -> float | None:
        """The charge of the battery, percent; None if it is not known."""
        if self.battery is None or not math.isfinite(self.battery.charge):
            return None
        return self.battery.charge * (1 if self._is_percent else 100)

    @property
    def pose(self) -> Pose2D | None:
        """The pose in the root frame; None if it is not known."""
        base = self._base
        return None if base is None else locate(self._frames, base)[1]

    @property
    def _base(self) -> str | None:
        """Return the frame of the robot's base; None before it is known."""
        frames = [frame for frame in self._frames if frame.rpartition("/")[2] in BASES]
        return min(frames, key=lambda frame: BASES.index(frame.rpartition("/")[2]), default=None)

    def scan_points(self) -> list[tuple[float, float]]:
        """Return the points of the newest scan, in the root frame, m."""
        if self.scan is None or self.scan.frame not in self._frames:
            return []
        scan = self.scan
        _, lidar = locate(self._frames, scan.frame)
        points = []
        for ray, reach in enumerate(scan.ranges):
            if scan.range_min <= reach <= scan.range_max:
                angle = lidar.yaw + scan.angle_min + ray * scan.angle_increment
                points.append(
                    (lidar.x + reach * math.cos(angle), lidar.y + reach * math.sin(angle))
                )
        return points

    def _extend_trail(self) -> None:
        if (base := self._base) is None:
            return
        root, pose = locate(self._frames, base)
        if not math.isfinite(pose.x + pose.y):
            return
        if root != self.frame:
            self.frame = root
            self.trail.clear()
        last = self.trail[-1] if self.trail else (math.inf, math.inf)
        if math.hypot(pose.x - last[0], pose.y - last[1]) >= TRAIL_STEP_M:
            self.trail.append((pose.x, pose.y))
