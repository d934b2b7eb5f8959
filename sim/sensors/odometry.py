"""Odometry: where the base is, reckoned from how far its wheels have turned."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from bt_mission.core.robot.model import RobotModel
from sim.faults import NO_ODOMETRY_FAULTS, OdometryFaults


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
        """Take the wheels' angles (rad) at `time_ns`; taken twice at one time, it counts once."""
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
