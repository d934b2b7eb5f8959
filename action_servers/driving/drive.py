"""What every driving maneuver watches: its sensors, its odometry, and a base that obeys."""

from __future__ import annotations

from dataclasses import dataclass

from action_servers.core.checks import stale
from action_servers.core.maneuver import ZERO, ErrorCode, Finished, Observation
from action_servers.core.odometer import Odometer
from action_servers.core.tuning import TUNING, Tuning
from bt_mission.core.geometry import Twist2D
from bt_mission.core.robot.model import RobotModel


class DriveGuard:
    """The guard of one driving maneuver.

    Every step begins with :meth:`fault` and ends with :meth:`command` or :meth:`rest`.
    """

    def __init__(self, robot: RobotModel, tuning: Tuning = TUNING) -> None:
        self._tuning = tuning
        self._period_s = 1.0 / robot.control_rate
        self._odometer = Odometer(robot.max_linear_velocity, robot.max_angular_velocity)
        self._progress = (
            ProgressWatch("m/s", tuning.blocked_after),
            ProgressWatch("rad/s", tuning.blocked_after),
        )
        self._course = CourseWatch(tuning.blocked_after)
        self._resting_since_s: float | None = None

    @property
    def distance(self) -> float:
        """Length of the path driven, metres."""
        return self._odometer.distance

    @property
    def yaw(self) -> float:
        """Rotation made, radians, left positive, not wrapped."""
        return self._odometer.yaw

    def fault(self, now: Observation) -> Finished | None:
        """Take in an observation; return how the goal ends if it cannot be driven by."""
        finished = stale(now, self._tuning.sensor_timeout)
        if finished is not None:
            return finished
        jump = self._odometer.update(now)
        return None if jump is None else Finished("aborted", ErrorCode.NO_ODOMETRY, jump)

    def delay_s(self, now: Observation) -> float:
        """Return the time until the next command takes effect, seen from the odometry at hand."""
        return self._period_s + max(0.0, now.time_s - now.odom_stamp_s)

    def command(self, now: Observation, twist: Twist2D) -> Twist2D | Finished:
        """Return the velocity, or the end of the goal when the base does not follow.

        Without a recent scan and odometry the base is held, so that it stands by the time at which
        they are given up (:meth:`fault`). A base that the pilot holds is not expected to follow.
        """
        self._resting_since_s = None
        if now.is_held or self._age_s(now) > self._tuning.hold_after:
            twist = ZERO
        linear, angular = self._progress
        blocked = linear.update(now.time_s, self.distance, twist.linear) or angular.update(
            now.time_s, self.yaw, twist.angular
        )
        return blocked or self._course.update(now, twist) or twist

    def _age_s(self, now: Observation) -> float:
        scan_s = now.time_s if now.scan is None else now.scan.stamp_s
        return now.time_s - min(scan_s, now.odom_stamp_s)

    def rest(self, now: Observation) -> Twist2D | None:
        """Return zero velocity until the base stands, then None."""
        if self._resting_since_s is None:
            self._resting_since_s = now.time_s
        velocity = now.velocity
        stands = (
            velocity is not None
            and abs(velocity.linear) < self._tuning.rest_linear
            and abs(velocity.angular) < self._tuning.rest_angular
        )
        settled = now.time_s - self._resting_since_s >= self._tuning.settle_limit
        return None if stands or settled else ZERO


@dataclass(slots=True)
class ProgressWatch:
    """Notices a base that does less than a tenth of what it is told, for `patience_s` on end.

    Works alike for metres and for radians; `unit` is that of the speed.
    """

    unit: str
    patience_s: float = TUNING.blocked_after
    _since_s: float | None = None
    _mark: float = 0.0

    def update(self, time_s: float, done: float, speed: float) -> Finished | None:
        """Take in what is done so far and the speed commanded; return the end when blocked."""
        enough = 0.1 * abs(speed) * self.patience_s
        if self._since_s is None or speed == 0.0 or abs(done - self._mark) >= enough:
            self._since_s, self._mark = time_s, done
            return None
        if time_s - self._since_s < self.patience_s:
            return None
        reason = (
            f"blocked: commanded {speed:.2f} {self.unit}, no progress for {self.patience_s:g} s"
        )
        return Finished("aborted", ErrorCode.BLOCKED, reason)


ASTRAY_RATE = 0.25
"""rad/s. An uneven floor turns a base that drives straight on by less, one wheel alone by more."""


@dataclass(slots=True)
class CourseWatch:
    """Notices a base that turns though it is told to drive straight, for `patience_s` on end.

    One wheel is blocked, or slips: the base goes round in circles, and makes way all the same.
    """

    patience_s: float = TUNING.blocked_after
    _since_s: float | None = None

    def update(self, now: Observation, twist: Twist2D) -> Finished | None:
        """Take in what odometry says and what is commanded; return the end when astray."""
        is_straight = twist.linear != 0.0 and twist.angular == 0.0
        if not is_straight or now.velocity is None or abs(now.velocity.angular) < ASTRAY_RATE:
            self._since_s = None
            return None
        if self._since_s is None:
            self._since_s = now.time_s
        if now.time_s - self._since_s < self.patience_s:
            return None
        reason = (
            f"astray: commanded straight on, turning at {now.velocity.angular:.2f} rad/s "
            f"for {self.patience_s:g} s; does a wheel block or slip?"
        )
        return Finished("aborted", ErrorCode.BLOCKED, reason)
