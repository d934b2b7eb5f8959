"""How the base responds to its commands, and when a goal sends feedback."""

from __future__ import annotations

import math
from dataclasses import dataclass

from action_servers.core.maneuver import Fields, Observation
from action_servers.core.tuning import TUNING
from bt_mission.base.geometry import Pose2D, Twist2D, distance, wrap
from bt_mission.robots.model import RobotModel

ASTRAY_RATE = 0.25
"""rad/s. An uneven floor turns a base that drives straight by less, a single driven wheel by more.
"""

LEAST_SHARE = 0.1
"""A share of the commanded speed: a base below it does not follow."""

_MOVED_M = 0.05
_TURNED_RAD = 0.2


@dataclass(slots=True)
class Odometer:
    """Adds up odometry poses.

    `max_linear` (m/s) and `max_angular` (rad/s) are the limits of the robot: a step between two
    poses that would need more than twice as much is a jump (odometry was reset), not a motion.

    `distance` is the length of the path in metres; `yaw` is the rotation in radians, left positive
    and not wrapped, so that two turns are 4 pi. `aside` is the part of `distance` on which the base
    gave way, and `aside_ahead` the same with backwards parts negative.
    """

    max_linear: float
    max_angular: float
    distance: float = 0.0
    yaw: float = 0.0
    aside: float = 0.0
    aside_ahead: float = 0.0
    _last: Pose2D | None = None
    _stamp_s: float = 0.0

    def update(self, now: Observation) -> str | None:
        """Add the newest pose; return an error or None."""
        pose = now.odom
        if pose is None or (self._last is not None and now.odom_stamp_s == self._stamp_s):
            return None
        last, self._last = self._last, pose
        elapsed = now.odom_stamp_s - self._stamp_s
        self._stamp_s = now.odom_stamp_s
        if last is None:
            return None
        moved = math.hypot(pose.x - last.x, pose.y - last.y)
        turned = math.remainder(pose.yaw - last.yaw, math.tau)
        if moved > 2.0 * self.max_linear * elapsed + 0.05:
            return f"odometry jumped by {moved:.2f} m in {elapsed:.3f} s; was it reset?"
        most = 2.0 * self.max_angular * elapsed + 0.1
        if not -most <= turned <= most:
            degrees = math.degrees(turned)
            return f"odometry jumped by {degrees:.0f} deg in {elapsed:.3f} s; was it reset?"
        self.distance += moved
        if now.held is not None and now.gives_way:
            ahead = math.cos(pose.yaw) * (pose.x - last.x) + math.sin(pose.yaw) * (pose.y - last.y)
            self.aside += moved
            self.aside_ahead += math.copysign(moved, ahead)
        self.yaw += turned
        return None


class Progress:
    """Detects, for one goal that drives, a base that does not follow its commands."""

    def __init__(self, robot: RobotModel, patience_s: float) -> None:
        self._odometer = Odometer(robot.max_linear_velocity, robot.max_angular_velocity)
        self._linear = AxisWatch("m/s", patience_s)
        self._angular = AxisWatch("rad/s", patience_s)
        self._course = CourseWatch(patience_s)

    def fault(self, now: Observation, commanded: Twist2D) -> str | None:
        """Handle an observation, and the command before it; return an error or None."""
        odometer = self._odometer
        odometer.update(now)
        for watch, done, speed in (
            (self._linear, odometer.distance, commanded.linear or commanded.lateral),
            (self._angular, odometer.yaw, commanded.angular),
        ):
            if speed == 0.0:
                watch.since_s, watch.mark = now.time_s, done
                continue
            fault = watch.fault(now.time_s, done, speed)
            if fault is not None:
                return fault
        return self._course.fault(now, commanded)


@dataclass(slots=True)
class AxisWatch:
    """Detects a base below a tenth of the commanded speed for `patience_s` in a row.

    It applies to metres and to radians; `unit` is that of the speed.
    """

    unit: str
    patience_s: float = TUNING.blocked_after
    since_s: float | None = None
    """The time since which it does not follow, or rests."""
    mark: float = 0.0
    """The position at that time."""

    def fault(self, time_s: float, done: float, speed: float) -> str | None:
        """Handle the position and the speed commanded; return an error or None."""
        enough = LEAST_SHARE * abs(speed) * self.patience_s
        if self.since_s is None or abs(done - self.mark) >= enough:
            self.since_s, self.mark = time_s, done
            return None
        if time_s - self.since_s < self.patience_s:
            return None
        return (
            f"blocked: commanded {speed:.2f} {self.unit}, no progress for {self.patience_s:g} s; "
            "the base is held, or refuses commands as late"
        )


@dataclass(slots=True)
class CourseWatch:
    """Detects a base that turns for `patience_s` in a row though the command is to drive straight.

    One wheel is blocked, or slips: the base drives in circles, and still makes progress.
    """

    patience_s: float = TUNING.blocked_after
    _since_s: float | None = None

    def fault(self, now: Observation, commanded: Twist2D) -> str | None:
        """Handle odometry, and the command before it; return an error or None."""
        is_straight = commanded.linear != 0.0 and commanded.angular == 0.0
        if not is_straight or now.velocity is None or abs(now.velocity.angular) < ASTRAY_RATE:
            self._since_s = None
            return None
        if self._since_s is None:
            self._since_s = now.time_s
        if now.time_s - self._since_s < self.patience_s:
            return None
        return (
            f"astray: commanded straight on, turning at {now.velocity.angular:.2f} rad/s "
            f"for {self.patience_s:g} s; does a wheel block or slip?"
        )


class ProgressChecker:
    """Measures how long the robot has stayed in place, whatever is commanded."""

    def __init__(self) -> None:
        self._anchor: Pose2D | None = None
        self._since_s = 0.0

    def standing_s(self, pose: Pose2D, time_s: float) -> float:
        """Return for how many seconds the robot has moved less than 0.05 m and 0.2 rad."""
        anchor = self._anchor
        if (
            anchor is None
            or distance(anchor, pose) > _MOVED_M
            or abs(wrap(pose.yaw - anchor.yaw)) > _TURNED_RAD
        ):
            self._anchor, self._since_s = pose, time_s
        return time_s - self._since_s

    def restart(self) -> None:
        """Measure from the next pose on."""
        self._anchor = None


ROUNDING_S = 1e-6


class Ticker:
    """Reports each full second once.

    Times are seconds as floats, so a second counts as full a microsecond early.
    """

    def __init__(self) -> None:
        self._start_s: float | None = None
        self._taken = 0
        self.elapsed_s = 0.0
        """Seconds since the first update."""

    @property
    def count(self) -> int:
        """The number of full seconds."""
        return int(self.elapsed_s + ROUNDING_S)

    def update(self, time_s: float) -> None:
        """Note the time of a control step, s."""
        if self._start_s is None:
            self._start_s = time_s
        self.elapsed_s = max(self.elapsed_s, time_s - self._start_s)

    def has_reached(self, duration_s: float) -> bool:
        """Return whether `duration_s` seconds have passed."""
        return self._start_s is not None and self.elapsed_s >= duration_s - ROUNDING_S

    def take(self) -> bool:
        """Return whether a second has become full since the last call."""
        before, self._taken = self._taken, self.count
        return self._taken > before


class ChangedFields:
    """Feedback that is sent when it has changed, and again after `again_s` seconds."""

    def __init__(self, again_s: float = math.inf) -> None:
        self._again_s = again_s
        self._sent: tuple[Fields, float] | None = None

    def of(self, fields: Fields, time_s: float = 0.0) -> Fields | None:
        """Return the fields if they are to be sent now, else None."""
        if self._sent is not None:
            sent, sent_s = self._sent
            if sent == fields and time_s - sent_s < self._again_s - ROUNDING_S:
                return None
        self._sent = fields, time_s
        return fields
