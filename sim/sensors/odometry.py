"""The counts of the wheels' encoders, and the odometry from them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

from bt_mission.core.robot.model import RobotModel
from sim.faults import PartFaults, SensorFaults, within
from sim.sensors.noise import Noise

Error = Annotated[float, within(-0.9, 9, "(relative)")]


class OdometryFaults(PartFaults):
    """Odometry that reckons with wrong figures, or drifts, or is silent."""

    left_radius_error: Error = 0.0
    """By how much its radius of the left wheel is too large, relative; both: distances are off."""
    right_radius_error: Error = 0.0
    separation_error: Error = 0.0
    """By how much its wheel separation is too large, relative: turns are off."""
    drift: Annotated[float, within(-10, 10, "m/s")] = 0.0
    """Drift ahead, m/s, whatever the wheels do."""
    turn_drift: Annotated[float, within(-360, 360, "deg/s")] = 0.0
    """Drift of the heading to the left, deg/s."""
    dead: bool = False
    """`odom` is not published, nor the transforms from it."""


NO_ODOMETRY_FAULTS = OdometryFaults()


class JointFaults(SensorFaults):
    """Encoders whose `joint_states` are not published; odometry continues."""


@dataclass
class Odometry:
    """Pose (m, m, rad) since the start, and velocity since the last reading (m/s, rad/s).

    The start is (0, 0, 0). It drifts from the truth where a wheel slips and where the wheels
    stand a little farther apart than the robot reckons, and further by the errors that the
    robot's settings give it.
    """

    robot: RobotModel
    x: float = field(default=0.0, init=False)
    y: float = field(default=0.0, init=False)
    yaw: float = field(default=0.0, init=False)
    linear: float = field(default=0.0, init=False)
    angular: float = field(default=0.0, init=False)
    _left: float = field(default=0.0, init=False)
    _right: float = field(default=0.0, init=False)
    time_ns: int | None = field(default=None, init=False)
    """When it was last read."""

    def read(
        self,
        left: float,
        right: float,
        time_ns: int,
        faults: OdometryFaults = NO_ODOMETRY_FAULTS,
    ) -> None:
        """Read the wheels' angles (rad) at `time_ns`; a repeated reading has no effect."""
        if self.time_ns is None:
            self._left, self._right, self.time_ns = left, right, time_ns
        if time_ns == self.time_ns:
            return
        drift = self.robot.sensors.odometry
        radius = self.robot.wheel_radius * (1 + drift.wheel_radius_error)
        separation = self.robot.wheel_separation * (1 + drift.wheel_separation_error)
        left_m, right_m = radius * (left - self._left), radius * (right - self._right)
        elapsed_s = (time_ns - self.time_ns) / 1e9
        if faults is not NO_ODOMETRY_FAULTS:
            left_m *= 1 + faults.left_radius_error
            right_m *= 1 + faults.right_radius_error
            separation *= 1 + faults.separation_error
        ahead = (left_m + right_m) / 2
        turned = (right_m - left_m) / separation
        if faults is not NO_ODOMETRY_FAULTS:
            ahead += faults.drift * elapsed_s
            turned += math.radians(faults.turn_drift) * elapsed_s
        # On an arc: the chord of a turn, in the direction of its middle.
        chord = ahead * _sinc(turned / 2)
        self.x += chord * math.cos(self.yaw + turned / 2)
        self.y += chord * math.sin(self.yaw + turned / 2)
        self.yaw = wrapped(self.yaw + turned)
        self.linear, self.angular = ahead / elapsed_s, turned / elapsed_s
        self._left, self._right, self.time_ns = left, right, time_ns


def wrapped(angle: float) -> float:
    """Return an angle (rad) in (-pi, pi]."""
    return math.pi - (math.pi - angle) % math.tau


def _sinc(angle: float) -> float:
    return math.sin(angle) / angle if abs(angle) > 1e-9 else 1.0


class Encoders:
    """Angles of both wheels since the start, rad.

    `slip` is the mean share of a wheel's turning without motion. Between two readings it varies by
    half of it (1 sigma), independently for each wheel, and is never negative.
    """

    def __init__(self, slip: float, seed: int, prefix: str = "") -> None:
        self._slip = slip
        self._noise = Noise(seed, f"{prefix}encoders", 2)
        self.start(0.0, 0.0)

    def start(self, left: float, right: float) -> None:
        """Count from these angles on, as at the first time."""
        self._index = 0
        self._start = self._last = (left, right)
        self._in_vain = (0.0, 0.0)

    def read(self, left: float, right: float) -> float:
        """Read the true angles. Return how far both wheels have turned together, rad."""
        turned = left - self._last[0], right - self._last[1]
        self._last = left, right
        if self._slip:
            shares = self._slip * (1 + self._noise.at(self._index) / 2).clip(min=0.0)
            self._in_vain = (
                self._in_vain[0] + turned[0] * float(shares[0]),
                self._in_vain[1] + turned[1] * float(shares[1]),
            )
            self._index += 1
        return abs(turned[0]) + abs(turned[1])

    def angles(self, left: float, right: float) -> tuple[float, float]:
        """Return the reading of the encoders at the true angles."""
        return (
            left - self._start[0] + self._in_vain[0],
            right - self._start[1] + self._in_vain[1],
        )
