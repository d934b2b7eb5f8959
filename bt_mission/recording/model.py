"""What is known of a run once its recording has been read: the base of reports and replays.

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

from bt_mission.events.events import NodeInfo
from bt_mission.requirements.monitor import RequirementResult

Floats = npt.NDArray[np.float64]
Times = npt.NDArray[np.int64]

FAILURE = "failure"
"""How a node or a mission ended."""


@dataclass(frozen=True)
class Span:
    """A node has run: from when it started until it ended, which may be one instant.

    `status` is how it ended: ``success``, ``failure`` or ``halted``; ``running`` where the
    recording ends before it did.
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
        """The newest pose at a time; the first one before it, None on an empty track."""
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
    """What the lidar measured: `points` are m, in the robot's frame (ahead, left), rows of x y.

    `clearance` is the distance of the nearest of them to the robot's hull, or to the lidar where
    the hull is not known; infinite where nothing was in reach.
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


@dataclass
class RecordedGoal:
    """The life of a goal. Times are None for what has not happened, or is not in the file.

    `status` is ``succeeded``, ``canceled``, ``aborted``, ``unknown``, ``rejected``, or empty;
    `values` and `result` are the fields of the messages.
    """

    id: str
    action: str
    type_name: str = ""
    owner: str = ""
    sent_ns: int | None = None
    accepted_ns: int | None = None
    rejected_ns: int | None = None
    handed_over_ns: int | None = None
    """When its leaf no longer wanted it."""
    cancel_ns: int | None = None
    ended_ns: int | None = None
    given_up_ns: int | None = None
    status: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)
    result: Mapping[str, Any] | None = None
    feedback: list[tuple[int, Mapping[str, Any]]] = field(default_factory=list)

    @property
    def end_ns(self) -> int | None:
        """When it ended, was rejected, or was given up."""
        known = (self.ended_ns, self.rejected_ns, self.given_up_ns)
        return next((time_ns for time_ns in known if time_ns is not None), None)


@dataclass(frozen=True)
class RecordedLine:
    """Something that was said; `level` is 10 debug, 20 info, 30 warning, 40 error, 50 fatal."""

    time_ns: int
    level: int
    name: str
    text: str


@dataclass(frozen=True)
class RecordedCollision:
    """The robot has come into contact with something, at a point of the map."""

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
    """What a requirement came to, and its margin at instants of the run.

    Attributes:
        times: Since the start, s.
        margins: In the unit of the result; `nan` where there is none.
        is_of_instants: Is each that of the instant by itself? Else it is that of the run so far.
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
    """What the recorder wrote down at the start: seed, robot, world, ..."""
    summary: Mapping[str, Any]
    """The :class:`bt_mission.executive.report.Report` as a mapping; empty where it is cut."""
    start_ns: int
    end_ns: int
    status: str
    """The last that is known: ``success``, ``failure``, ``interrupted``, or of one that runs."""
    reason: str
    why_cut: str
    """Why the file ends before its end; empty where it does not."""
    missing: str
    """What the recorder could not record; empty where it could everything."""
    tree: tuple[NodeInfo, ...]
    spans: tuple[tuple[Span, ...], ...]
    """Of each node of the tree."""
    truth: Track
    """Where the robot was; empty where only the robot itself knows."""
    measured: Track
    """Where it took itself to be, by its odometry from the first pose on."""
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
    """Front, rear (negative) and half width of the robot, m; None where it is not known."""
    inputs: Mapping[str, Any] = field(default_factory=dict)
    """Of the mission."""
    requirements: tuple[RecordedRequirement, ...] = ()

    @property
    def track(self) -> Track:
        """The best that is known of where the robot was."""
        return self.truth if len(self.truth) else self.measured
