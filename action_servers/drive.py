"""What every driving maneuver watches: its sensors, its odometry, and a base that obeys."""

from __future__ import annotations

from dataclasses import dataclass

from action_servers.freshness import stale
from action_servers.maneuver import ZERO, ErrorCode, Finished, Observation, Twist2D
from action_servers.odometer import Odometer
from bt_mission.common.robot import RobotModel

BLOCKED_AFTER_S = 2.0
"""Seconds without progress after which a maneuver gives up."""

REST_LINEAR = 0.01
"""m/s below which the base counts as standing."""

REST_ANGULAR = 0.02
"""rad/s below which the base counts as standing."""

SETTLE_LIMIT_S = 1.0
"""Seconds after which a base that was told to stop counts as standing, whatever is measured."""


class Drive:
    """The guard of one driving maneuver.

    Every step begins with :meth:`fault` and ends with :meth:`command` or :meth:`rest`.
    """

    def __init__(self, robot: RobotModel) -> None:
        self._period_s = 1.0 / robot.control_rate
        self._odometer = Odometer(robot.max_linear_velocity, robot.max_angular_velocity)
        self._progress = (ProgressWatch("m/s"), ProgressWatch("rad/s"))
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
        finished = stale(now)
        if finished is not None:
            return finished
        jump = self._odometer.update(now)
        return None if jump is None else Finished("aborted", ErrorCode.NO_ODOMETRY, jump)

    def delay_s(self, now: Observation) -> float:
        """Return the time until the next command takes effect, seen from the odometry at hand."""
        return self._period_s + max(0.0, now.time_s - now.odom_stamp_s)

    def command(self, now: Observation, twist: Twist2D) -> Twist2D | Finished:
        """Return the velocity, or the end of the goal when the base does not follow."""
        self._resting_since_s = None
        linear, angular = self._progress
        blocked = linear.update(now.time_s, self.distance, twist.linear) or angular.update(
            now.time_s, self.yaw, twist.angular
        )
        return blocked or twist

    def rest(self, now: Observation) -> Twist2D | None:
        """Return zero velocity until the base stands, then None."""
        if self._resting_since_s is None:
            self._resting_since_s = now.time_s
        velocity = now.velocity
        stands = (
            velocity is not None
            and abs(velocity.linear) < REST_LINEAR
            and abs(velocity.angular) < REST_ANGULAR
        )
        return None if stands or now.time_s - self._resting_since_s >= SETTLE_LIMIT_S else ZERO


@dataclass(slots=True)
class ProgressWatch:
    """Notices a base that does less than a tenth of what it is told, for a time on end.

    Works alike for metres and for radians; `unit` is that of the speed.
    """

    unit: str
    _since_s: float | None = None
    _mark: float = 0.0

    def update(self, time_s: float, done: float, speed: float) -> Finished | None:
        """Take in what is done so far and the speed commanded; return the end when blocked."""
        enough = 0.1 * abs(speed) * BLOCKED_AFTER_S
        if self._since_s is None or speed == 0.0 or abs(done - self._mark) >= enough:
            self._since_s, self._mark = time_s, done
            return None
        if time_s - self._since_s < BLOCKED_AFTER_S:
            return None
        reason = (
            f"blocked: commanded {speed:.2f} {self.unit}, no progress for {BLOCKED_AFTER_S:g} s"
        )
        return Finished("aborted", ErrorCode.BLOCKED, reason)
