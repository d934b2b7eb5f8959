"""The life of the robot, from the messages of its sensors."""

from __future__ import annotations

import math

import numpy as np

from bt_mission.base.geometry import Pose2D, yaw_of
from bt_mission.cdr.decoder import DecodedMessage
from bt_mission.executive.events.reader import transforms
from bt_mission.executive.events.robot_state import BASES, Frames, frames_of, locate
from bt_mission.recording.model import (
    Floats,
    RecordedCollision,
    RecordedGrid,
    RecordedScan,
    Series,
    Track,
)
from bt_mission.recording.recorded_messages import ODOMETRY, TRUTH, RobotMessage

Hull = tuple[float, float, float]

MIDDLE = Pose2D(0.0, 0.0, 0.0)


class RobotLife:
    """Reads the messages of one robot, in the order of time.

    Args:
        namespace: The robot's namespace.
        hull: Front, rear and half width, m; None if it is not known.
    """

    def __init__(self, namespace: str, hull: Hull | None) -> None:
        self.hull = None if hull is None else (hull[0], hull[1], hull[2])
        self.grid: RecordedGrid | None = None
        self.collisions: list[RecordedCollision] = []
        self.namespace = namespace.rstrip("/")
        self._poses: dict[str, list[tuple[float, ...]]] = {TRUTH: [], ODOMETRY: []}
        self._battery: list[tuple[int, float]] = []
        self._scans: list[tuple[int, str, Floats]] = []
        """Scans with frame, and the ranges and angles of their points, in columns."""
        self._frames: Frames = {}
        self._map_to_odom: Pose2D | None = None

    def take(self, time_ns: int, happening: RobotMessage) -> None:
        """Handle a message. Raises DecodingError for one of another type."""
        happening.check_type()
        match happening.topic:
            case "ground_truth/odom" | "odom" as name:
                self._poses[name].append(_pose(time_ns, happening.message))
            case "scan":
                scan = happening.message
                self._scans.append((time_ns, scan.header.frame_id.lstrip("/"), _seen(scan)))
            case "battery_state":
                share = happening.message.percentage
                if math.isfinite(share):
                    self._battery.append((time_ns, share))
            case "map":
                self._take_grid(time_ns, happening.message)
            case "collisions":
                hit = happening.message
                place = hit.point.x, hit.point.y
                self.collisions.append(RecordedCollision(time_ns, hit.obstacle, *place, hit.force))
            case "tf_static":
                self._frames |= frames_of(transforms(happening.message))
            case "tf" if self._map_to_odom is None:
                frames = frames_of(transforms(happening.message))
                parent, pose = frames.get("odom", ("", MIDDLE))
                if parent == "map":
                    self._map_to_odom = pose

    # ---- results ----------------------------------------------------------------------------

    @property
    def truth(self) -> Track:
        """The true poses, if a simulation has them."""
        return _track(self._poses[TRUTH], MIDDLE)

    @property
    def measured(self) -> Track:
        """The poses by odometry, from the first pose on."""
        return _track(self._poses[ODOMETRY], self._map_to_odom or MIDDLE)

    @property
    def battery(self) -> Series:
        """Percentage over time."""
        times, values = zip(*self._battery, strict=True) if self._battery else ((), ())
        return Series(np.array(times, np.int64), np.array(values, np.float64))

    @property
    def scans(self) -> tuple[RecordedScan, ...]:
        """All scans, as points around the robot."""
        frames = {frame for _, frame, _ in self._scans}
        places = {frame: locate(self._frames, frame, roots=BASES)[1] for frame in frames}
        return tuple(
            self._scan(time_ns, places[frame], seen) for time_ns, frame, seen in self._scans
        )

    def _take_grid(self, time_ns: int, message: DecodedMessage) -> None:
        info, origin = message["info"], message["info"]["origin"]["position"]
        shape = (info["height"], info["width"])
        if message["data"].size == shape[0] * shape[1]:
            cells = message["data"].reshape(shape)
            self.grid = RecordedGrid(time_ns, info["resolution"], origin["x"], origin["y"], cells)

    # ---- geometry --------------------------------------------------------------------------

    def _scan(self, time_ns: int, at: Pose2D, seen: Floats) -> RecordedScan:
        ranges, angles = seen[:, 0], seen[:, 1] + at.yaw
        points = np.column_stack((at.x + ranges * np.cos(angles), at.y + ranges * np.sin(angles)))
        return RecordedScan(time_ns, points, self._clearance(points, ranges))

    def _clearance(self, points: Floats, ranges: Floats) -> float:
        if not len(points):
            return math.inf
        if self.hull is None:
            return float(ranges.min())
        front, rear, half_width = self.hull
        ahead = np.maximum(np.maximum(points[:, 0] - front, rear - points[:, 0]), 0.0)
        aside = np.maximum(np.abs(points[:, 1]) - half_width, 0.0)
        return float(np.hypot(ahead, aside).min())


def _seen(message: DecodedMessage) -> Floats:
    ranges: Floats = message["ranges"].astype(np.float64)
    angles = message["angle_min"] + message["angle_increment"] * np.arange(len(ranges))
    with np.errstate(invalid="ignore"):
        seen = (ranges >= message["range_min"]) & (ranges <= message["range_max"])
    return np.column_stack((ranges[seen], angles[seen]))


def _pose(time_ns: int, message: DecodedMessage) -> tuple[float, ...]:
    pose, twist = message.pose.pose, message.twist.twist
    place, yaw = pose.position, yaw_of(pose.orientation)
    return time_ns, place.x, place.y, yaw, twist.linear.x, twist.angular.z


def _track(rows: list[tuple[float, ...]], origin: Pose2D) -> Track:
    table = np.array(rows, np.float64).reshape(-1, 6)
    times = np.array([row[0] for row in rows], np.int64)
    x, y, yaw = table[:, 1], table[:, 2], table[:, 3]
    if origin != MIDDLE:
        cos, sin = math.cos(origin.yaw), math.sin(origin.yaw)
        x, y = origin.x + cos * x - sin * y, origin.y + sin * x + cos * y
        yaw = yaw + origin.yaw
    return Track(times, x, y, yaw, table[:, 4], table[:, 5])
