"""What became of the robot, out of the messages of its sensors."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from bt_mission.recording.model import (
    Floats,
    RecordedCollision,
    RecordedGrid,
    RecordedScan,
    Series,
    Track,
)

Decode = Callable[[], Mapping[str, Any]]
Hull = tuple[float, float, float]
Pose = tuple[float, float, float]

TRUTH, ODOMETRY = "ground_truth/odom", "odom"
BASES = ("base_footprint", "base_link")


class RobotLife:
    """Takes in the messages of one robot, in the order of time.

    :param namespace: of the robot; other topics are no concern of it.
    :param hull: front, rear and half width, m; None where it is not known.
    """

    def __init__(self, namespace: str, hull: Hull | None) -> None:
        self.hull = None if hull is None else (hull[0], hull[1], hull[2])
        self.grid: RecordedGrid | None = None
        self.collisions: list[RecordedCollision] = []
        self._prefix = namespace.rstrip("/") + "/"
        self._poses: dict[str, list[tuple[float, ...]]] = {TRUTH: [], ODOMETRY: []}
        self._battery: list[tuple[int, float]] = []
        self._scans: list[tuple[int, str, Mapping[str, Any]]] = []
        self._frames: dict[str, tuple[str, Pose]] = {}
        self._map_to_odom: Pose | None = None
        self._takers: dict[str, Callable[[int, Mapping[str, Any]], None]] = {
            TRUTH: lambda at, message: self._take_pose(TRUTH, at, message),
            ODOMETRY: lambda at, message: self._take_pose(ODOMETRY, at, message),
            "scan": self._take_scan,
            "battery_state": self._take_battery,
            "map": self._take_grid,
            "collisions": self._take_collision,
            "tf_static": self._take_frames,
        }

    def take(self, topic: str, time_ns: int, decode: Decode) -> None:
        """Take in a message, if it is of use."""
        name = topic.removeprefix(self._prefix)
        taker = self._takers.get(name)
        if taker is not None:
            taker(time_ns, decode())
        elif name == "tf" and self._map_to_odom is None:
            self._take_transforms(decode())

    # ---- what came of it -------------------------------------------------------------------

    @property
    def truth(self) -> Track:
        """Where it truly was, as far as a simulation tells."""
        return _track(self._poses[TRUTH], (0.0, 0.0, 0.0))

    @property
    def measured(self) -> Track:
        """Where it took itself to be, from the first pose on."""
        return _track(self._poses[ODOMETRY], self._map_to_odom or (0.0, 0.0, 0.0))

    @property
    def battery(self) -> Series:
        """Percentage over time."""
        times, values = zip(*self._battery, strict=True) if self._battery else ((), ())
        return Series(np.array(times, np.int64), np.array(values, np.float64))

    @property
    def scans(self) -> tuple[RecordedScan, ...]:
        """All scans, as points around the robot."""
        return tuple(
            self._scan(time_ns, self._place_of(frame), message)
            for time_ns, frame, message in self._scans
        )

    # ---- messages --------------------------------------------------------------------------

    def _take_pose(self, topic: str, time_ns: int, message: Mapping[str, Any]) -> None:
        at, twist = message["pose"]["pose"], message["twist"]["twist"]
        place, turned = at["position"], at["orientation"]
        self._poses[topic].append(
            (
                time_ns,
                place["x"],
                place["y"],
                _yaw(turned),
                twist["linear"]["x"],
                twist["angular"]["z"],
            )
        )

    def _take_battery(self, time_ns: int, message: Mapping[str, Any]) -> None:
        if math.isfinite(message["percentage"]):
            self._battery.append((time_ns, message["percentage"]))

    def _take_scan(self, time_ns: int, message: Mapping[str, Any]) -> None:
        self._scans.append((time_ns, message["header"]["frame_id"], message))

    def _take_grid(self, time_ns: int, message: Mapping[str, Any]) -> None:
        info, origin = message["info"], message["info"]["origin"]["position"]
        shape = (info["height"], info["width"])
        if message["data"].size == shape[0] * shape[1]:
            cells = message["data"].reshape(shape)
            self.grid = RecordedGrid(time_ns, info["resolution"], origin["x"], origin["y"], cells)

    def _take_collision(self, time_ns: int, message: Mapping[str, Any]) -> None:
        point = message["point"]
        self.collisions.append(
            RecordedCollision(
                time_ns, message["obstacle"], point["x"], point["y"], message["force"]
            )
        )

    def _take_frames(self, _time_ns: int, message: Mapping[str, Any]) -> None:
        for one in message["transforms"]:
            self._frames[one["child_frame_id"]] = (one["header"]["frame_id"], _planar(one))

    def _take_transforms(self, message: Mapping[str, Any]) -> None:
        for one in message["transforms"]:
            if (one["header"]["frame_id"], one["child_frame_id"]) == ("map", "odom"):
                self._map_to_odom = _planar(one)

    # ---- geometry --------------------------------------------------------------------------

    def _place_of(self, frame: str) -> Pose:
        """Where a sensor stands on the robot; in the middle where no frames tell."""
        pose, seen = (0.0, 0.0, 0.0), set()
        while frame in self._frames and frame not in BASES and frame not in seen:
            seen.add(frame)
            frame, inner = self._frames[frame]
            pose = _composed(inner, pose)
        return pose

    def _scan(self, time_ns: int, at: Pose, message: Mapping[str, Any]) -> RecordedScan:
        ranges: Floats = message["ranges"].astype(np.float64)
        angles = message["angle_min"] + message["angle_increment"] * np.arange(len(ranges))
        with np.errstate(invalid="ignore"):
            seen = (ranges >= message["range_min"]) & (ranges <= message["range_max"])
        ranges, angles = ranges[seen], angles[seen] + at[2]
        points = np.column_stack((at[0] + ranges * np.cos(angles), at[1] + ranges * np.sin(angles)))
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


def _track(rows: list[tuple[float, ...]], origin: Pose) -> Track:
    table = np.array(rows, np.float64).reshape(-1, 6)
    times = np.array([row[0] for row in rows], np.int64)
    x, y, yaw = table[:, 1], table[:, 2], table[:, 3]
    if any(origin):
        cos, sin = math.cos(origin[2]), math.sin(origin[2])
        x, y = origin[0] + cos * x - sin * y, origin[1] + sin * x + cos * y
        yaw = yaw + origin[2]
    return Track(times, x, y, yaw, table[:, 4], table[:, 5])


def _planar(transform: Mapping[str, Any]) -> Pose:
    moved = transform["transform"]
    return moved["translation"]["x"], moved["translation"]["y"], _yaw(moved["rotation"])


def _yaw(turned: Mapping[str, float]) -> float:
    w, x, y, z = turned["w"], turned["x"], turned["y"], turned["z"]
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def _composed(outer: Pose, inner: Pose) -> Pose:
    cos, sin = math.cos(outer[2]), math.sin(outer[2])
    return (
        outer[0] + cos * inner[0] - sin * inner[1],
        outer[1] + sin * inner[0] + cos * inner[1],
        outer[2] + inner[2],
    )
