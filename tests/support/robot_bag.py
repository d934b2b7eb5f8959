"""A recording of a robot that knows nothing of missions, written by a library that is not ours."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mcap_ros2.writer import Writer

from bt_mission.base.interface_files import share_folders
from bt_mission.cdr.definitions import Definitions
from bt_mission.language.mission import Requirement
from bt_mission.recording.verification import RecordedRequirements, Verification

START_NS = 1_700_000_000_000_000_000
ODOMETRY, SCAN = "nav_msgs/msg/Odometry", "sensor_msgs/msg/LaserScan"


class RobotBag:
    """An MCAP file such as `ros2 bag record -s mcap` leaves behind.

    Args:
        path: Of the file.
        namespace: Of the robot.
    """

    def __init__(self, path: Path, namespace: str = "") -> None:
        self.path = path
        self._namespace = namespace
        self._writer = Writer(str(path))
        self._schemas: dict[str, Any] = {}

    def odometry(self, time_s: float, *, x: float, speed: float) -> None:
        """Add what the wheels tell."""
        pose = {"position": {"x": x, "y": 0.0, "z": 0.0}, "orientation": _still("xyz", w=1.0)}
        twist = {"linear": _still("yz", x=speed), "angular": _still("xyz")}
        message = {
            "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "odom"},
            "child_frame_id": "base_footprint",
            "pose": {"pose": pose, "covariance": [0.0] * 36},
            "twist": {"twist": twist, "covariance": [0.0] * 36},
        }
        self._write(time_s, "odom", ODOMETRY, message)

    def scan(
        self,
        time_s: float,
        ranges: Sequence[float],
        *,
        increment: float = 0.0,
        stamp_s: float | None = None,
    ) -> None:
        """Add a scan from straight ahead on; the lidar reaches from 0.1 m to 10 m.

        `stamp_s` counts from the start of the recording; None leaves the stamp at zero.
        """
        stamp_ns = 0 if stamp_s is None else START_NS + round(stamp_s * 1e9)
        figures = ("angle_min", "angle_max", "time_increment", "scan_time")
        stamp = dict(zip(("sec", "nanosec"), divmod(stamp_ns, 10**9), strict=True))
        message = {
            "header": {"stamp": stamp, "frame_id": "base_scan"},
            **dict.fromkeys(figures, 0.0),
            "angle_increment": increment,
            "range_min": 0.1,
            "range_max": 10.0,
            "ranges": list(ranges),
            "intensities": [],
        }
        self._write(time_s, "scan", SCAN, message)

    def raw(self, time_s: float, topic: str, data: bytes) -> None:
        """Add bytes as the message of a topic that there is."""
        writer: Any = self._writer._writer  # the library writes no wrong messages
        channel = self._writer._channel_ids[topic]
        time_ns = START_NS + round(time_s * 1e9)
        writer.add_message(channel, time_ns, data, time_ns, 0)

    def close(self) -> Path:
        """End the file; return its path."""
        self._writer.finish()
        return self.path

    def _write(self, time_s: float, topic: str, type_name: str, message: Any) -> None:
        if type_name not in self._schemas:
            text = Definitions(share_folders()).of(type_name)
            self._schemas[type_name] = self._writer.register_msgdef(type_name, text)
        time_ns = START_NS + round(time_s * 1e9)
        self._writer.write_message(
            f"{self._namespace}/{topic}", self._schemas[type_name], message, time_ns, time_ns
        )


def _still(axes: str, **others: float) -> dict[str, float]:
    return {**dict.fromkeys(axes, 0.0), **others}


def verify(path: Path, *formulas: str, requirements: tuple[Requirement, ...] = ()) -> Verification:
    """Evaluate requirements over a recording: these, or its own."""
    recorded = RecordedRequirements(path)
    named = tuple(Requirement(text, text) for text in formulas)
    return recorded.verify(named or requirements or recorded.own())
