"""The speeds of a robot: how fast it may go to stop in time, and how gently it accelerates."""

from __future__ import annotations

import math
from dataclasses import dataclass

from action_servers.core.maneuver import ZERO
from bt_mission.base.geometry import Twist2D
from bt_mission.robots.model import RobotModel

_TURN_SHARE = 0.6
_BRAKE_SHARE = 0.4
_SPIN_BRAKE_SHARE = 0.3
_GAIN_PER_S = 4.0


def speed_to_stop_in(distance: float, *, deceleration: float, delay_s: float) -> float:
    """Return the highest speed from which the base stops within `distance`.

    It continues at that speed for `delay_s` (until the next command takes effect) and then brakes
    at `deceleration`: distance = v * delay + v**2 / (2 * deceleration), solved for v. It applies to
    metres and to radians; 0 for a distance of 0 or less, inf for an infinite one.
    """
    if distance <= 0.0:
        return 0.0
    return deceleration * (math.sqrt(delay_s**2 + 2.0 * distance / deceleration) - delay_s)


@dataclass(frozen=True, slots=True)
class DriveLimits:
    """m/s, rad/s, m/s², rad/s².

    `linear` and the accelerations are the robot's limits. It turns at a share of its angular limit,
    and brakes early, so that it follows commands even with a control step of delay.
    """

    linear: float
    angular: float
    acceleration: float
    angular_acceleration: float

    def approach(self, distance: float) -> float:
        """Return the speed from which the robot stops gently within a distance in metres."""
        gentle = _BRAKE_SHARE * self.acceleration
        return min(self.linear, math.sqrt(2 * gentle * max(0.0, distance)))

    def spin(self, angle: float) -> float:
        """Return the angular velocity that ends smoothly after an angle in radians, signed."""
        gentle = _SPIN_BRAKE_SHARE * self.angular_acceleration
        rate = min(self.angular, math.sqrt(2 * gentle * abs(angle)), _GAIN_PER_S * abs(angle))
        return math.copysign(rate, angle)


def limits(robot: RobotModel) -> DriveLimits:
    """Return the limits for navigating with a robot."""
    return DriveLimits(
        robot.max_linear_velocity,
        _TURN_SHARE * robot.max_angular_velocity,
        robot.max_linear_acceleration,
        robot.max_angular_acceleration,
    )


class Ramp:
    """Changes one twist to another no faster than the robot accelerates."""

    def __init__(self, limits: DriveLimits, twist: Twist2D = ZERO) -> None:
        self._limits = limits
        self.twist = twist

    def toward(self, wanted: Twist2D, seconds: float) -> Twist2D:
        """Return the twist to command for the next control step, `seconds` after the last."""
        self.twist = Twist2D(
            _nearer(self.twist.linear, wanted.linear, self._limits.acceleration * seconds),
            _nearer(
                self.twist.angular, wanted.angular, self._limits.angular_acceleration * seconds
            ),
            _nearer(self.twist.lateral, wanted.lateral, self._limits.acceleration * seconds),
        )
        return self.twist

    def stop(self) -> Twist2D:
        """Return a zero twist, from which the ramp then starts."""
        self.twist = ZERO
        return ZERO


def _nearer(value: float, wanted: float, step: float) -> float:
    return value + min(step, max(-step, wanted - value))
