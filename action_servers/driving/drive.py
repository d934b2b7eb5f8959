"""The motion of a driving maneuver: distance, speed, and standing."""

from __future__ import annotations

import math

from action_servers.core.drive_limits import speed_to_stop_in
from action_servers.core.limits import SLOWEST_DRIVE, SLOWEST_TURN
from action_servers.core.maneuver import ZERO, ErrorCode, Finished, Observation, Reason, stale
from action_servers.core.progress import Odometer
from action_servers.core.tuning import TUNING, Tuning
from bt_mission.base.geometry import Twist2D
from bt_mission.robots.model import RobotModel

_SENSES = (Reason.NO_ODOMETRY, Reason.NO_SCAN)

ARRIVED_WITHIN = 0.003
"""Metres before the end at which the robot is commanded to stop."""

TURNED_WITHIN = math.radians(0.3)
"""Rotation before the end at which the robot is commanded to stop."""


class Drive(Odometer):
    """The motion of one driving maneuver; every step begins with :meth:`fault`."""

    def __init__(self, robot: RobotModel, tuning: Tuning = TUNING) -> None:
        super().__init__(robot.max_linear_velocity, robot.max_angular_velocity)
        self._tuning = tuning
        self._robot = robot
        self._resting_since_s: float | None = None

    def advance(self, direction: float) -> float:
        """Return the way made in a direction (1 ahead, -1 back), metres.

        It is the distance, but for what the base gave way: that counts by where it led.
        """
        return self.distance - self.aside + direction * self.aside_ahead

    def fault(self, now: Observation) -> Finished | None:
        """Handle an observation; return the end of the goal if it cannot drive.

        The goal also ends if the base does not follow, or if an obstacle holds it for long.
        """
        held, limit_s = now.held, self._tuning.blocked_after
        if held is not None and held.by in _SENSES:
            finished = stale(now, self._tuning.sensor_timeout)
            if finished is not None:
                return finished
        jump = self.update(now)
        if jump is not None:
            return Finished("aborted", ErrorCode.NO_ODOMETRY, jump)
        if held is None:
            return None
        if held.by is Reason.OBSTACLE and held.is_standing and now.time_s - held.since_s >= limit_s:
            return held.ended(f", for {limit_s:g} s")
        return held.ended() if held.by is Reason.BASE else None

    def speed_ahead(self, now: Observation, remaining: float, most: float) -> float:
        """Return the speed, up to `most` m/s, that allows a stop in `remaining` metres."""
        within = self._braking(now, remaining, self._robot.max_linear_acceleration)
        return min(most, max(SLOWEST_DRIVE, within))

    def rate_towards(self, now: Observation, remaining: float, most: float) -> float:
        """Return the rate, up to `most` rad/s, that allows a stop in `remaining` radians."""
        within = self._braking(now, remaining, self._robot.max_angular_acceleration)
        return min(most, max(SLOWEST_TURN, within))

    def turn_towards(
        self, now: Observation, target: float, speed: float
    ) -> Twist2D | Finished | None:
        """Return the velocity that turns the base until `yaw` is `target`, at up to `speed` rad/s.

        None when the target is reached; the end of the goal if an obstacle is in the way.
        """
        remaining = target - self.yaw
        if abs(remaining) <= TURNED_WITHIN:
            return None
        held = now.held
        if held is not None and held.by is Reason.OBSTACLE and held.is_standing:
            return held.ended(
                f": an obstacle is within the circle of {self._robot.turning_radius:.3f} m that "
                f"the robot sweeps; {math.degrees(abs(remaining)):.0f} deg remained"
            )
        rate = self.rate_towards(now, abs(remaining), speed)
        return Twist2D(0.0, math.copysign(rate, remaining))

    def _braking(self, now: Observation, remaining: float, acceleration: float) -> float:
        self._resting_since_s = None
        # Half of what the base can do, so that it follows the slowing down with ease.
        gentle = 0.5 * acceleration
        # From the newest odometry until the next command takes effect.
        delay_s = 1.0 / self._robot.control_rate
        if now.time_s > now.odom_stamp_s:
            delay_s += now.time_s - now.odom_stamp_s
        return speed_to_stop_in(remaining, deceleration=gentle, delay_s=delay_s)

    def rest(self, now: Observation) -> Twist2D | None:
        """Return zero velocity until the base stands, then None; a request for a speed ends it."""
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
