"""A run that was read from its recording: the base of reports and replays.

All times are ROS times in ns, as in the file; :attr:`RecordedRun.start_ns` is the first instant.
Lengths are m, angles rad, in the frame of the map unless another is named.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bt_mission.base.verdicts import RequirementResult
from bt_mission.executive.events.events import NodeInfo
from bt_mission.recording.goal_lives import RecordedGoal

Floats = npt.NDArray[np.float64]
Times = npt.NDArray[np.int64]

FAILURE = "failure"
"""The statuses of a failed node or mission."""


@dataclass(frozen=True)
class Span:
    """The run of a node from its start to its end, which may be one instant.

    `status` is its final status: ``success``, ``failure`` or ``halted``; ``running`` if the
    recording ends earlier.
    """

    start_ns: int
    end_ns: int
    status: str
    message: str


@dataclass(frozen=True)
class Track:
    """Poses and velocities over time: `x`, `y` m, `yaw` rad, `speed` m/s, `turn` rad/s."""

    times: Times
    x: Floats
    y: Floats
    yaw: Floats
    speed: Floats
    turn: Floats

    def __len__(self) -> int:
        return len(self.times)

    def at(self, time_ns: int) -> tuple[float, float, float] | None:
        """Return the newest pose at a time; the first one before it, None on an empty track."""
        if not len(self.times):
            return None
        number = max(0, int(np.searchsorted(self.times, time_ns, side="right")) - 1)
        return float(self.x[number]), float(self.y[number]), float(self.yaw[number])

    @property
    def distance(self) -> Floats:
        """Length of the way so far, m, at each time."""
        steps = np.hypot(np.diff(self.x), np.diff(self.y))
        return np.concatenate(([0.0], np.cumsum(steps))) if len(self.times) else self.x


@dataclass(frozen=True)
class Series:
    """A figure over time."""

    times: Times
    values: Floats

    def __len__(self) -> int:
        return len(self.times)


@dataclass(frozen=True)
class RecordedScan:
    """A measurement of the lidar: `points` are m, in the robot's frame (ahead, left), rows of x y.

    `clearance` is the distance of the nearest of them to the robot's hull, or to the lidar if the
    hull is not known; infinite without a point in range.
    """

    time_ns: int
    points: Floats
    clearance: float


@dataclass(frozen=True)
class RecordedGrid:
    """An occupancy grid: `cells` are rows from low y up; -1 unknown, 0 free to 100 occupied."""

    time_ns: int
    resolution: float
    x: float
    y: float
    cells: npt.NDArray[np.int8]


@dataclass(frozen=True)
class RecordedLine:
    """A line of a log; `level` is 10 debug, 20 info, 30 warning, 40 error, 50 fatal."""

    time_ns: int
    level: int
    name: str
    text: str


@dataclass(frozen=True)
class RecordedCollision:
    """The robot has touched something, at a point of the map."""

    time_ns: int
    obstacle: str
    x: float
    y: float
    force: float


@dataclass(frozen=True)
class Picture:
    """A picture that the run has saved, or a camera has sent."""

    time_ns: int
    name: str
    media_type: str
    data: bytes = field(repr=False)


@dataclass(frozen=True)
class RecordedRequirement:
    """The result of a requirement, and its margin at instants of the run.

    Attributes:
        times: Time since the start, s.
        margins: In the unit of the result; `nan` without a margin.
        is_of_instants: Whether each is that of the instant alone. Otherwise it is that of the run
            so far.
    """

    result: RequirementResult
    times: Floats
    margins: Floats
    is_of_instants: bool


@dataclass(frozen=True)
class RecordedRun:
    """A recorded run of one mission."""

    path: Path
    mission: str
    node: str
    """Full name of the executive's node."""
    facts: Mapping[str, str]
    """The facts of the start: seed, robot, world, ..."""
    summary: Mapping[str, Any]
    """The :class:`bt_mission.executive.report.Report` as a mapping; empty if the file is cut."""
    start_ns: int
    end_ns: int
    status: str
    """The last known status: ``success``, ``failure``, ``interrupted``, or that of a running
    mission.
    """
    reason: str
    why_cut: str
    """Why the file ends early; empty if it is complete."""
    missing: str
    """The parts that the recorder could not record; empty if it is complete."""
    tree: tuple[NodeInfo, ...]
    spans: tuple[tuple[Span, ...], ...]
    """The spans of each node of the tree."""
    truth: Track
    """The true poses; empty without a simulation."""
    measured: Track
    """The poses of its odometry, starting at the first true pose."""
    scans: tuple[RecordedScan, ...]
    grid: RecordedGrid | None
    """The newest map."""
    goals: tuple[RecordedGoal, ...]
    log: tuple[RecordedLine, ...]
    battery: Series
    """Percentage."""
    collisions: tuple[RecordedCollision, ...]
    pictures: tuple[Picture, ...]
    files: Mapping[str, str]
    """The mission's file and those it includes, by name."""
    versions: Mapping[str, Any]
    hull: tuple[float, float, float] | None
    """Front, rear (negative) and half width of the robot, m; None if it is not known."""
    inputs: Mapping[str, Any] = field(default_factory=dict)
    """Of the mission."""
    requirements: tuple[RecordedRequirement, ...] = ()

    @property
    def track(self) -> Track:
        """The best that is known of where the robot was."""
        return self.truth if len(self.truth) else self.measured
