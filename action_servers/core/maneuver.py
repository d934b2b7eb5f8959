"""Maneuvers: the pure core of every action server.

A maneuver runs one goal. It is stepped by the pilot at the control rate, gets an
:class:`Observation` of the robot and returns a velocity, or :class:`Finished`. It uses neither ROS
nor a wall clock, so it is tested in microseconds.

Frames follow REP 103 and REP 105: x forward, y left, yaw counter-clockwise; poses of the base are
those of ``base_footprint``, the point on the floor below the middle of the axle.

The `error_code` of results: one list for all actions.

Checks of the robot's state when a goal arrives; a refusal names what was expected.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import TYPE_CHECKING, Literal, Protocol, TypeAlias, Union

from action_servers.core.tuning import TUNING
from bt_mission.base.dds.liveliness import EXECUTIVE_LOST
from bt_mission.base.geometry import Pose2D, Twist2D

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt


class ErrorCode(IntEnum):
    """The reason of a goal's end; 0 means no error for every action.

    From 900 on those of `bt_mission_interfaces`. Those of navigation are Nav2's: 1xx of
    `nav2_msgs/action/FollowPath`, 2xx of `ComputePathToPose`, 600 of `FollowWaypoints`.
    """

    NONE = 0

    TF_ERROR_WHILE_DRIVING = 102
    FAILED_TO_MAKE_PROGRESS = 105
    CONTROLLER_TIMED_OUT = 107
    TF_ERROR_WHILE_PLANNING = 202
    START_OUTSIDE_MAP = 203
    GOAL_OUTSIDE_MAP = 204
    START_OCCUPIED = 205
    GOAL_OCCUPIED = 206
    NO_VALID_PATH = 208
    WAYPOINTS_UNKNOWN = 600

    UNKNOWN = 900
    STOPPED = 901
    NO_SCAN = 902
    NO_ODOMETRY = 903
    NO_IMAGE = 904
    STORAGE = 905
    BLOCKED = 906
    MOTORS_OFF = 907
    NO_MAP = 908
    EXECUTIVE_LOST = EXECUTIVE_LOST


ZERO = Twist2D()

_TOWARDS = 0.1
"""The cosine of the angle at which a twist just drives past a hazard."""


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """One turn of the lidar: angles in radians (left positive, 0 ahead), ranges in metres.

    `ranges` has one value per ray, in the order of the rays; any number of rays. A value may be
    inf, NaN, 0 or outside [`range_min`, `range_max`] (REP 117 and what real lidars send).
    """

    stamp_s: float
    angle_min: float
    angle_increment: float
    range_min: float
    range_max: float
    ranges: npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Occupancy grid of the map frame: `cells[row, column]`, row along y, column along x.

    `resolution` is the edge of a cell in metres; `origin_x`, `origin_y` the corner of
    `cells[0, 0]` in metres. A cell holds 0 (free) to 100 (occupied), or -1 (unknown).
    """

    resolution: float
    origin_x: float
    origin_y: float
    cells: npt.NDArray[np.int8]
    stamp: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """A picture of the camera: `rgb` is `height` x `width` x 3, 8 bits each.

    `frame` is the camera's.
    """

    stamp_s: float
    height: int
    width: int
    rgb: npt.NDArray[np.uint8]
    frame: str = ""


@dataclass(frozen=True, slots=True)
class Hazard:
    """What a pressed bumper or a cliff sensor reports: its bearing, rad from ahead, and a text."""

    bearing: float
    words: str

    def is_towards(self, twist: Twist2D) -> bool:
        """Return whether a twist drives in its direction. Turning on the spot does not."""
        way = math.hypot(twist.linear, twist.lateral)
        ahead = twist.linear * math.cos(self.bearing) + twist.lateral * math.sin(self.bearing)
        return ahead > _TOWARDS * way


@dataclass(frozen=True, slots=True)
class Guard:
    """A bumper or a cliff sensor: its topic, and the time of its newest message, s; None before.

    `patience_s` is the age that follows from its own rate.
    """

    topic: str
    stamp_s: float | None
    patience_s: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class JointReadings:
    """Positions (rad or m), velocities and forces of joints, each by the joint's name."""

    stamp_s: float
    positions: Mapping[str, float]
    velocities: Mapping[str, float]
    efforts: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """The state of the robot at one control step: the newest message of each kind.

    `time_s` is ROS time in seconds, and so are the stamps. `odom` is the pose in the odometry
    frame, `velocity` the one that odometry measures, `map_pose` the pose in the map frame.
    `frame_on_map` gives the pose on the map of a frame by its name, or why it is not known.
    Anything that has not arrived yet is None. `scan`, `grid` and `image` are the same objects
    from step to step until a newer message comes, so an identity test shows whether they are new.
    `held` says what holds the base: why what the maneuver wanted last was not commanded, or is not
    going to be now. While it `gives_way`, what is in the way of the goal does not end it. `hazards`
    are those of bumpers and cliff sensors, which are `guards`. No goal drives faster than
    `speed_limit`, m/s.
    """

    time_s: float
    odom: Pose2D | None = None
    odom_stamp_s: float = 0.0
    velocity: Twist2D | None = None
    scan: Scan | None = None
    map_pose: Pose2D | None = None
    grid: Grid | None = None
    image: Image | None = None
    frame_on_map: Callable[[str], Pose2D | Refusal] | None = None
    held: Held | None = None
    hazards: tuple[Hazard, ...] = ()
    guards: tuple[Guard, ...] = ()
    joints: JointReadings | None = None
    speed_limit: float = math.inf

    @property
    def held_by(self) -> Reason | None:
        """Why the base is held, if it is."""
        return None if self.held is None else self.held.by

    @property
    def gives_way(self) -> bool:
        """Whether the base gives way to an obstacle, or is about to."""
        return self.held is not None and self.held.by is Reason.MOVING


@dataclass(frozen=True, slots=True)
class Finished:
    """The end of a goal; `error_code` and `reason` are in the result."""

    status: Literal["succeeded", "aborted"]
    error_code: int = 0
    reason: str = ""


SUCCEEDED = Finished("succeeded")


class Reason(Enum):
    """The reason that holds the base."""

    EXECUTIVE = "a late executive"
    NO_ODOMETRY = "old odometry"
    NO_SCAN = "an old scan, or a silent bumper or cliff sensor"
    OBSTACLE = "an obstacle"
    MOVING = "something that moves"
    BASE = "the base itself, which does not follow"

    @property
    def code(self) -> ErrorCode:
        """The error code of a goal that is given up for this reason."""
        return _CODES.get(self, ErrorCode.BLOCKED)


_CODES = {
    Reason.EXECUTIVE: ErrorCode.EXECUTIVE_LOST,
    Reason.NO_ODOMETRY: ErrorCode.NO_ODOMETRY,
    Reason.NO_SCAN: ErrorCode.NO_SCAN,
}


@dataclass(frozen=True, slots=True)
class Held:
    """The reason for which the base is held, the command instead, and the start, s of ROS time."""

    by: Reason
    words: str
    twist: Twist2D
    since_s: float

    @property
    def is_standing(self) -> bool:
        """Whether the base stands; otherwise it is slowed down, or driven elsewhere."""
        return self.twist == ZERO

    def ended(self, detail: str = "") -> Finished:
        """Return the end of a goal that does not wait, with a detail after the text."""
        return Finished("aborted", self.by.code, self.words + detail)


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why a goal is not accepted: what was expected, what was got."""

    reason: str


# A field of a feedback or result message. A Pose2D fills a Pose, or a PoseStamped in the map
# frame; a number of seconds fills a Duration or a Time; bytes fill a sequence of uint8; a mapping
# fills a nested message.
Value: TypeAlias = Union[bool, int, float, str, bytes, Pose2D, Twist2D, "Fields", "Sequence[Value]"]
Fields: TypeAlias = Mapping[str, Value]


class Maneuver(Protocol):
    """One goal that runs. An exception raised by any method aborts the goal."""

    @property
    def needs_base(self) -> bool:
        """Whether it drives. At most one driving maneuver runs at a time."""

    def step(self, now: Observation) -> Twist2D | Finished:
        """Return the velocity to command until the next control step, or the end of the goal."""

    def feedback(self) -> Mapping[str, Value] | None:
        """Return the fields of a feedback message, or None without a change since the last."""

    def result(self) -> Mapping[str, Value]:
        """Return the fields of the result, apart from `error_code` and `error_msg`.

        Valid at any time: also before the first step, and when canceled or replaced.
        """


def refusal(*faults: str | None, unready: Finished | None = None) -> Refusal | None:
    """Return why a goal is refused, or None: its first error, else what is not ready."""
    reasons = (*faults, None if unready is None else unready.reason)
    return next((Refusal(reason) for reason in reasons if reason is not None), None)


def missing(now: Observation) -> str | None:
    """Return what navigation needs and has not received yet, or None."""
    if now.grid is None:
        return "no map has arrived yet; is something publishing the topic map?"
    if now.grid.cells.size == 0:
        return "the map has no cells"
    if now.map_pose is None:
        return "the robot's place on the map is not known yet; is something publishing map to odom?"
    if now.scan is None:
        return "no scan has arrived yet; is the robot running?"
    return None


def stale(now: Observation, limit_s: float = TUNING.sensor_timeout) -> Finished | None:
    """Return the end of a goal that drives without fresh scan, guards and odometry, or None.

    A stamp from the future is as invalid as an old one: both mean that clocks differ.
    """
    if now.odom is not None and now.scan is not None:
        ages = now.time_s - now.odom_stamp_s, now.time_s - now.scan.stamp_s
        if -limit_s <= ages[0] <= limit_s and -limit_s <= ages[1] <= limit_s:
            return _ended_by(silent_guard(now, limit_s)) if now.guards else None
    finished = stale_odometry(now, limit_s)
    if finished is not None:
        return finished
    scan_stamp = None if now.scan is None else now.scan.stamp_s
    return _ended_by(overdue("scan", scan_stamp, now.time_s, limit_s))


def silent_guard(now: Observation, limit_s: float) -> str | None:
    """Return which bumper or cliff sensor is silent, or None."""
    for guard in now.guards:
        limit = max(limit_s, guard.patience_s)
        reason = overdue(guard.topic, guard.stamp_s, now.time_s, limit)
        if reason is not None:
            return reason
    return None


def _ended_by(reason: str | None) -> Finished | None:
    return None if reason is None else Finished("aborted", ErrorCode.NO_SCAN, reason)


def stale_odometry(now: Observation, limit_s: float = TUNING.sensor_timeout) -> Finished | None:
    """Return the end of a goal that needs only fresh odometry, or None."""
    stamp_s = None if now.odom is None else now.odom_stamp_s
    reason = overdue("odometry", stamp_s, now.time_s, limit_s)
    return None if reason is None else Finished("aborted", ErrorCode.NO_ODOMETRY, reason)


def stale_joints(now: Observation, limit_s: float = TUNING.sensor_timeout) -> str | None:
    """Return why arm and gripper cannot be moved: their joints are not known; or None."""
    stamp_s = None if now.joints is None else now.joints.stamp_s
    return overdue("joint_states", stamp_s, now.time_s, limit_s)


def overdue(what: str, stamp_s: float | None, time_s: float, limit_s: float) -> str | None:
    """Return why a stamp is older than a limit, s, or from the future; None if it is neither."""
    if stamp_s is None:
        return f"no {what} has arrived yet; is the robot running?"
    age = time_s - stamp_s
    if age > limit_s:
        return f"no {what} for {limit_s:g} s: the last is {age:.2f} s old"
    if age < -limit_s:
        return f"the last {what} is stamped {-age:.2f} s in the future; do the clocks agree?"
    return None
