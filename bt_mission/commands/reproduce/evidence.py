"""What a recording says of a robot: its path, its scans, its commands, its topics and its goals.

The memory is bounded: of long recordings every second sample is dropped until they fit.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from bt_mission.base.geometry import Pose2D, composed, wrap, yaw_of
from bt_mission.base.stamps import NS
from bt_mission.base.stamps import to_ns as stamp_ns
from bt_mission.executive.events.messages import ZoneDisc
from bt_mission.executive.events.reader import transforms, zones
from bt_mission.executive.events.robot_state import BASES, MAP_FRAME, Frames, frames_of, locate
from bt_mission.recording.goal_lives import GoalLives, RecordedGoal
from bt_mission.recording.model import RecordedGrid
from bt_mission.recording.reading import RecordedFile
from bt_mission.recording.recorded_messages import (
    TRUTH,
    GoalMessage,
    RecordedMessage,
    RobotMessage,
    RosoutMessage,
    fold,
)

Floats = npt.NDArray[np.float64]

MOST_ROWS = 100_000
"""Of a series: 80 minutes at 20 Hz before samples are dropped."""
MOST_RAYS = 6_000_000
"""Of all scans: 24 MB."""
MOST_LINES = 200
MOST_GAPS = 500
SILENT_PERIODS = 4.0
"""A topic is silent after this number of its periods without a message ..."""
SILENT_S = 0.3
"""... and this time, s."""
USUAL_AFTER = 8
"""Messages after which the period of a topic is known."""
WARNING = 30


class Rows:
    """Rows of numbers; every second one is dropped when there are too many."""

    def __init__(self, width: int, most: int = MOST_ROWS) -> None:
        self._width, self._most = width, most
        self._values = array("d")
        self._stride, self._count = 1, 0

    def add(self, *row: float) -> None:
        """Add a row; the first value is the time, s."""
        self._count += 1
        if self._count % self._stride:
            return
        self._values.extend(row)
        if len(self._values) >= self._most * self._width:
            kept = self.table()[::2]
            self._values = array("d", kept.ravel())
            self._stride *= 2

    def table(self) -> Floats:
        """Return the rows."""
        return np.array(self._values, np.float64).reshape(-1, self._width)


@dataclass
class TopicLife:
    """When the messages of a topic arrived, s: its silences, and how late stamps are."""

    first_s: float = math.inf
    last_s: float = -math.inf
    count: int = 0
    gaps: list[tuple[float, float]] = field(default_factory=list)
    lateness: Rows = field(default_factory=lambda: Rows(2, 20_000))
    """Times, and the age of the stamp on arrival, s."""
    _periods: list[float] = field(default_factory=list)

    @property
    def period_s(self) -> float:
        """The usual time between two messages, s; infinite before it is known."""
        return float(np.median(self._periods)) if len(self._periods) >= USUAL_AFTER else math.inf

    def take(self, time_s: float) -> None:
        """Take an arrival."""
        if self.count:
            step = time_s - self.last_s
            if len(self._periods) < 64:
                self._periods.append(step)
            limit = max(SILENT_S, SILENT_PERIODS * min(self.period_s, 1.0))
            if step > limit and self.count >= 2 and len(self.gaps) < MOST_GAPS:
                self.gaps.append((self.last_s, time_s))
        self.first_s = min(self.first_s, time_s)
        self.last_s = max(self.last_s, time_s)
        self.count += 1

    def silences(self, end_s: float) -> list[tuple[float, float | None]]:
        """Return the silences that its period does not explain; the last may have no end."""
        if self.count <= USUAL_AFTER:
            return []
        limit = max(SILENT_S, SILENT_PERIODS * self.period_s)
        intervals: list[tuple[float, float | None]] = [
            gap for gap in self.gaps if gap[1] - gap[0] > limit
        ]
        if end_s - self.last_s > limit:
            intervals.append((self.last_s, None))
        return intervals


@dataclass(frozen=True, slots=True)
class SeenScan:
    """A turn of the lidar: times are s since the start."""

    time_s: float
    stamp_s: float
    angle_min: float
    increment: float
    range_min: float
    range_max: float
    ranges: npt.NDArray[np.float32]


@dataclass(frozen=True)
class Path2D:
    """Poses over time, s: the best that is known of where the robot was."""

    times: Floats
    x: Floats
    y: Floats
    yaw: Floats
    """Unwrapped, rad."""
    frame: str

    def __len__(self) -> int:
        return len(self.times)

    def at(self, times: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the poses at times, between the nearest known ones."""
        return (
            np.interp(times, self.times, self.x),
            np.interp(times, self.times, self.y),
            np.interp(times, self.times, self.yaw),
        )

    def pose(self, time_s: float) -> Pose2D:
        """Return the pose at a time."""
        x, y, yaw = self.at(np.array([time_s]))
        return Pose2D(float(x[0]), float(y[0]), wrap(float(yaw[0])))

    def motion(self, times: Floats, over_s: float = 0.3) -> tuple[Floats, Floats, Floats]:
        """Return the velocity ahead and to the left, m/s, and the turn rate, rad/s, at times."""
        x0, y0, yaw0 = self.at(times - over_s / 2)
        x1, y1, yaw1 = self.at(times + over_s / 2)
        _, _, yaw = self.at(times)
        dx, dy = (x1 - x0) / over_s, (y1 - y0) / over_s
        cos, sin = np.cos(yaw), np.sin(yaw)
        return cos * dx + sin * dy, cos * dy - sin * dx, (yaw1 - yaw0) / over_s


class EvidenceReader:
    """Reads the messages of one robot: a fold of a recording."""

    def __init__(self) -> None:
        self._first_ns: int | None = None
        self.topics: dict[str, TopicLife] = {}
        self.largest_back_ns = 0
        self._newest_ns = 0
        self._namespace: str | None = None
        self._goals = GoalLives()
        self._odometry, self._truth, self._tf = Rows(6), Rows(4), Rows(4)
        self._commands, self._imu, self._wheels = Rows(3), Rows(2), Rows(3)
        self._battery = Rows(2)
        self._scans: list[SeenScan] = []
        self._scan_stride, self._scan_count = 1, 0
        self._scan_frame = ""
        self._frames: Frames = {}
        self._tf_root = ""
        self._frozen = _Frozen()
        self._scan_stamp = 0
        self.grid: RecordedGrid | None = None
        self.zones: tuple[ZoneDisc, ...] = ()
        self.lines: list[tuple[float, str]] = []
        self.plan_end: list[tuple[float, Pose2D]] = []
        self.ignored: set[str] = set()

    @classmethod
    def of(cls, file: RecordedFile) -> Self:
        """Read a file. Raises RecordingError."""
        reader = cls()
        fold(file, reader.take)
        return reader

    def take(self, time_ns: int, happening: RecordedMessage) -> None:
        """Take the next message."""
        if self._first_ns is None:
            self._first_ns = time_ns
        self.largest_back_ns = max(self.largest_back_ns, self._newest_ns - time_ns)
        self._newest_ns = max(self._newest_ns, time_ns)
        now = time_ns / NS
        if isinstance(happening, GoalMessage):
            self._goals.take(time_ns, happening)
        elif isinstance(happening, RosoutMessage):
            line = happening.message
            if line.level >= WARNING and len(self.lines) < MOST_LINES:
                self.lines.append((now, f"{line.name}: {line.msg}"))
        else:
            self._take_topic(now, happening)

    def _take_topic(self, now: float, happening: RecordedMessage) -> None:
        topic = happening.channel.topic
        place, _, name = topic.rpartition("/")
        if isinstance(happening, RobotMessage):
            place, name = happening.namespace, happening.topic
        take = _READERS.get(name)
        if take is None:
            return
        if name in ("scan", "odom") and self._namespace is None:
            self._namespace = place
        if self._namespace is not None and place != self._namespace and name not in GLOBAL:
            self.ignored.add(topic)
            return
        self.topics.setdefault(name, TopicLife()).take(now)
        take(self, now, happening)

    # ---- topics ------------------------------------------------------------------------------

    def take_odometry(self, now: float, happening: RecordedMessage) -> None:
        """Take the pose and the velocity by the wheels."""
        message = happening.message
        pose, twist = message.pose.pose, message.twist.twist
        yaw = yaw_of(pose.orientation)
        row = now, pose.position.x, pose.position.y, yaw, twist.linear.x, twist.angular.z
        if all(map(math.isfinite, row)):
            self._odometry.add(*row)
        self._note_lateness("odom", now, message)

    def take_truth(self, now: float, happening: RecordedMessage) -> None:
        """Take the true pose, which only a simulation has."""
        pose = happening.message.pose.pose
        self._truth.add(now, pose.position.x, pose.position.y, yaw_of(pose.orientation))

    def take_transforms(self, now: float, happening: RecordedMessage) -> None:
        """Take transforms; those of the base give its path."""
        changed = frames_of(transforms(happening.message))
        self._frames |= changed
        base = next((name for name in BASES if name in self._frames), None)
        if base is None or not any(child in BASES for child in changed):
            return
        root, pose = locate(self._frames, base)
        if self._tf_root not in ("", root) and root == MAP_FRAME:
            self._tf = Rows(4)  # the map comes later: what was before has another origin
        self._tf_root = MAP_FRAME if self._tf_root == MAP_FRAME else root
        if root == self._tf_root and math.isfinite(pose.x + pose.y + pose.yaw):
            self._tf.add(now, pose.x, pose.y, pose.yaw)

    def take_static(self, _now: float, happening: RecordedMessage) -> None:
        """Take transforms that do not change."""
        self._frames |= frames_of(transforms(happening.message))

    def take_scan(self, now: float, happening: RecordedMessage) -> None:
        """Take a scan."""
        message = happening.message
        stamp = stamp_ns(message.header.stamp)
        if stamp and stamp == self._scan_stamp:
            return  # the same scan once more, not another one with the same ranges
        self._scan_stamp = stamp
        self._scan_frame = message.header.frame_id.lstrip("/")
        ranges = message.ranges.astype(np.float32)
        self._note_lateness("scan", now, message)
        self._frozen.take(now, ranges)
        self._scan_count += 1
        if self._scan_count % self._scan_stride:
            return
        self._scans.append(
            SeenScan(
                now,
                stamp / NS,
                float(message.angle_min),
                float(message.angle_increment),
                float(message.range_min),
                float(message.range_max),
                ranges,
            )
        )
        if sum(scan.ranges.size for scan in self._scans[-1:]) * len(self._scans) > MOST_RAYS:
            self._scans = self._scans[::2]
            self._scan_stride *= 2

    def take_command(self, now: float, happening: RecordedMessage) -> None:
        """Take a command to the base."""
        message = happening.message
        twist = message.get("twist", message)
        self._commands.add(now, twist["linear"].x, twist["angular"].z)

    def take_imu(self, now: float, happening: RecordedMessage) -> None:
        """Take a turn rate."""
        self._imu.add(now, happening.message.angular_velocity.z)

    def take_wheels(self, now: float, happening: RecordedMessage) -> None:
        """Take the speeds of the wheels, rad/s, left and right."""
        message = happening.message
        names = [str(name) for name in message.name]
        left = next((number for number, name in enumerate(names) if "left" in name), None)
        right = next((number for number, name in enumerate(names) if "right" in name), None)
        if left is not None and right is not None and len(message.velocity) == len(names):
            self._wheels.add(now, float(message.velocity[left]), float(message.velocity[right]))

    def take_battery(self, now: float, happening: RecordedMessage) -> None:
        """Take the charge of the battery."""
        share = float(happening.message.percentage)
        if math.isfinite(share):
            self._battery.add(now, share)

    def take_map(self, now: float, happening: RecordedMessage) -> None:
        """Take a map; the newest counts."""
        message = happening.message
        info, origin = message.info, message.info.origin.position
        if message.data.size == info.height * info.width and message.data.size:
            cells = message.data.reshape(info.height, info.width).astype(np.int8)
            self.grid = RecordedGrid(round(now * NS), info.resolution, origin.x, origin.y, cells)

    def take_zones(self, _now: float, happening: RecordedMessage) -> None:
        """Take the marks on the floor."""
        self.zones = zones(happening.message).zones

    def take_plan(self, now: float, happening: RecordedMessage) -> None:
        """Take the end of a planned path: the goal of navigation."""
        poses = happening.message.poses
        if poses and len(self.plan_end) < MOST_ROWS:
            pose = poses[-1].pose
            place = Pose2D(pose.position.x, pose.position.y, yaw_of(pose.orientation))
            if not self.plan_end or self.plan_end[-1][1] != place:
                self.plan_end.append((now, place))

    def _note_lateness(self, name: str, now: float, message: Any) -> None:
        self.topics[name].lateness.add(now, now - stamp_ns(message.header.stamp) / NS)

    # ---- the end -----------------------------------------------------------------------------

    def evidence(self, path: Path, start_ns: int | None = None) -> Evidence:
        """Return all of it, with times in s since the start.

        Args:
            path: The file, for messages.
            start_ns: ROS time of the start; None is that of the first goal, or else of the first
                message.
        """
        goals = sorted(
            (goal for goal in self._goals.lives if goal.start_ns), key=lambda goal: goal.start_ns
        )
        first_ns = self._first_ns or 0
        if start_ns is None:
            start_ns = goals[0].start_ns - BEFORE_FIRST_GOAL_NS if goals else first_ns
        start_s = start_ns / NS
        odometry = _since(self._odometry.table(), start_s)
        return Evidence(
            path=path,
            start_ns=start_ns,
            end_s=self._newest_ns / NS - start_s,
            first_s=first_ns / NS - start_s,
            topics=self.topics,
            track=self._track(odometry, start_s),
            truth=_path(_since(self._truth.table(), start_s), MAP_FRAME),
            odometry=odometry,
            commands=_since(self._commands.table(), start_s),
            imu=_since(self._imu.table(), start_s),
            wheels=_since(self._wheels.table(), start_s),
            battery=_since(self._battery.table(), start_s),
            scans=[_scan_since(scan, start_s) for scan in self._scans],
            frozen=[(begin - start_s, end - start_s) for begin, end in self._frozen.spans()],
            mount=locate(self._frames, self._scan_frame, roots=BASES)[1],
            grid=self.grid,
            zones=self.zones,
            goals=goals,
            lines=[(time - start_s, text) for time, text in self.lines],
            plan_ends=[(time - start_s, pose) for time, pose in self.plan_end],
            ignored=sorted(self.ignored),
            largest_back_ns=self.largest_back_ns,
        )

    def _track(self, odometry: Floats, start_s: float) -> Path2D:
        poses = _since(self._tf.table(), start_s)
        if len(poses) >= 2:
            return _path(poses, self._tf_root)
        return _path(odometry[:, :4], "odom")


BEFORE_FIRST_GOAL_NS = 50_000_000
"""A mission sends its first goal in its first control step."""

GLOBAL = ("tf", "tf_static", "map", "zones", "plan")
"""Topics that are not in the namespace of the robot in every graph."""

_READERS = {
    "odom": EvidenceReader.take_odometry,
    TRUTH: EvidenceReader.take_truth,
    "tf": EvidenceReader.take_transforms,
    "tf_static": EvidenceReader.take_static,
    "scan": EvidenceReader.take_scan,
    "cmd_vel": EvidenceReader.take_command,
    "imu": EvidenceReader.take_imu,
    "joint_states": EvidenceReader.take_wheels,
    "battery_state": EvidenceReader.take_battery,
    "map": EvidenceReader.take_map,
    "zones": EvidenceReader.take_zones,
    "plan": EvidenceReader.take_plan,
}


class _Frozen:
    """Notes when scans repeat the one before, to the last bit; times are s."""

    def __init__(self) -> None:
        self._last: npt.NDArray[np.float32] | None = None
        self._last_s = 0.0
        self._begin: float | None = None
        self._spans: list[tuple[float, float]] = []

    def take(self, now: float, ranges: npt.NDArray[np.float32]) -> None:
        """Take a scan."""
        same = self._last is not None and np.array_equal(self._last, ranges, equal_nan=True)
        if same and np.isfinite(ranges).any():
            self._begin = self._last_s if self._begin is None else self._begin
        elif self._begin is not None:
            self._spans.append((self._begin, now))
            self._begin = None
        self._last, self._last_s = ranges, now

    def spans(self) -> list[tuple[float, float]]:
        """Return beginnings and ends."""
        rest = [] if self._begin is None else [(self._begin, self._last_s)]
        return [*self._spans, *rest]


@dataclass(frozen=True)
class Evidence:
    """The contents of a recording; times are s since the start, tables have a row for each time.

    Attributes:
        track: The poses by the transforms: on the map if something localises the robot.
        truth: The true poses; empty without a simulation.
        odometry: Time, x, y, yaw, speed m/s, turn rate rad/s.
        commands: Time, speed m/s, turn rate rad/s.
        imu: Time, turn rate rad/s.
        wheels: Time, left and right rad/s.
        battery: Time, charge as published.
        mount: The place of the lidar on the base.
    """

    path: Path
    start_ns: int
    end_s: float
    first_s: float
    topics: dict[str, TopicLife]
    track: Path2D
    truth: Path2D
    odometry: Floats
    commands: Floats
    imu: Floats
    wheels: Floats
    battery: Floats
    scans: Sequence[SeenScan]
    frozen: Sequence[tuple[float, float]]
    mount: Pose2D
    grid: RecordedGrid | None
    zones: Sequence[ZoneDisc]
    goals: Sequence[RecordedGoal]
    lines: Sequence[tuple[float, str]]
    plan_ends: Sequence[tuple[float, Pose2D]]
    ignored: Sequence[str]
    largest_back_ns: int

    @property
    def is_localised(self) -> bool:
        """Whether poses are on a map, and not only counted by the wheels."""
        return self.track.frame == MAP_FRAME

    @property
    def counts(self) -> dict[str, int]:
        """The number of messages of each topic."""
        return {name: life.count for name, life in self.topics.items()}

    def since_start(self, time_ns: int) -> float:
        """Return a time since the start, s."""
        return (time_ns - self.start_ns) / NS

    def lidar_pose(self, scan: SeenScan) -> Pose2D:
        """Return where the lidar was on the map when it measured."""
        late = scan.time_s - scan.stamp_s
        return composed(
            self.track.pose(scan.stamp_s if 0 <= late < 1.0 else scan.time_s), self.mount
        )


def points_of(scan: SeenScan, lidar: Pose2D) -> tuple[Floats, npt.NDArray[np.intp]]:
    """Return the points of a scan on the map, rows of x and y, m, and the numbers of their rays."""
    ranges = scan.ranges.astype(np.float64)
    with np.errstate(invalid="ignore"):
        rays = np.flatnonzero((ranges >= scan.range_min) & (ranges <= scan.range_max))
    angles = lidar.yaw + scan.angle_min + scan.increment * rays
    lengths = ranges[rays]
    return np.column_stack(
        (lidar.x + lengths * np.cos(angles), lidar.y + lengths * np.sin(angles))
    ), rays


def _since(table: Floats, start_s: float) -> Floats:
    if len(table):
        table[:, 0] -= start_s
    return table


def _path(table: Floats, frame: str) -> Path2D:
    if len(table) > 1:
        table = table[np.concatenate(([True], np.diff(table[:, 0]) > 0))]
    return Path2D(table[:, 0], table[:, 1], table[:, 2], np.unwrap(table[:, 3]), frame)


def _scan_since(scan: SeenScan, start_s: float) -> SeenScan:
    return SeenScan(
        scan.time_s - start_s,
        scan.stamp_s - start_s,
        scan.angle_min,
        scan.increment,
        scan.range_min,
        scan.range_max,
        scan.ranges,
    )
