"""What is known of a robot: where it is and was, what its lidar sees, its map, its battery."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Iterable

from bt_mission.core.geometry import Pose2D, composed
from bt_mission.events import messages

BASES = ("base_footprint", "base_link")
"""Frames that are the robot, the best first; with a prefix before a slash, too."""

TRAIL_STEP_M = 0.05
"""A place is kept when the robot is so far from the one before."""

TRAIL_POINTS = 5_000
MAP_FRAME = "map"
FRAME_LEVELS = 50
"""Frames between the root and a sensor; more are a circle."""


Frames = dict[str, tuple[str, Pose2D]]
"""Of each frame its parent, and where it is in that."""


def frames_of(transforms: Iterable[messages.FrameTransform]) -> Frames:
    """Return the frames that transforms tell of."""
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
    """A robot, from what it tells. Feed it with :meth:`take`."""

    def __init__(self) -> None:
        self.map: messages.Map | None = None
        self.zones: tuple[messages.ZoneDisc, ...] = ()
        self.scan: messages.ScanPoints | None = None
        self.battery: messages.BatteryState | None = None
        self.trail: deque[tuple[float, float]] = deque(maxlen=TRAIL_POINTS)
        self.others: dict[str, Pose2D] = {}
        """Where other robots are on the map, by their names."""
        self.frame = ""
        """The frame that pose and trail are in: ``map``, or ``odom`` where nobody localises."""
        self._frames: Frames = {}
        self._is_percent = False

    def take(self, reading: messages.Robot) -> None:
        """Take in what the robot tells."""
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
        """Of the battery, percent; None where it is not known."""
        if self.battery is None or not math.isfinite(self.battery.charge):
            return None
        return self.battery.charge * (1 if self._is_percent else 100)

    @property
    def pose(self) -> Pose2D | None:
        """Where the robot is in its root frame; None where it is not known."""
        base = self._base
        return None if base is None else locate(self._frames, base)[1]

    @property
    def _base(self) -> str | None:
        """The frame that is the robot; None where there is none yet."""
        frames = [frame for frame in self._frames if frame.rpartition("/")[2] in BASES]
        return min(frames, key=lambda frame: BASES.index(frame.rpartition("/")[2]), default=None)

    def scan_points(self) -> list[tuple[float, float]]:
        """Where the newest scan has seen something, in the root frame, m."""
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
