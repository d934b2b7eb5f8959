"""The counts of the wheels' encoders, and the odometry from them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from operator import mul
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from bt_mission.robots.model import RobotModel
from sim.faults import PartFaults, SensorFaults, within
from sim.sensors.sensor import Noise

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
    lateral: float = field(default=0.0, init=False)
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
        wheels: Any = self.robot.drive
        radius = wheels.wheel_radius * (1 + drift.wheel_radius_error)
        separation = wheels.wheel_separation * (1 + drift.wheel_separation_error)
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


class PlanarOdometry:
    """Pose (m, m, rad) since the start, and velocity (m/s, rad/s), from any number of wheels.

    The motion is the one that suits the turns of all wheels best.

    Args:
        robot: The robot, with the errors of its odometry.
        rows: The rotation of each wheel (rad/s) per velocity ahead and to the left, m/s, and
            turned to the left, rad/s.
    """

    def __init__(self, robot: RobotModel, rows: npt.NDArray[np.float64]) -> None:
        self._options = robot.sensors.odometry
        self._motion: list[list[float]] = np.linalg.pinv(rows).tolist()
        if not robot.drive.slide_velocity:
            self._motion[1] = [0.0] * len(rows)
        self._is_left = [y > 0 for _, y in robot.drive.places]
        self.x = self.y = self.yaw = 0.0
        self.linear = self.lateral = self.angular = 0.0
        self._angles: Sequence[float] | None = None
        self.time_ns: int | None = None
        """When it was last read."""

    def read(
        self,
        angles: Sequence[float],
        time_ns: int,
        faults: OdometryFaults = NO_ODOMETRY_FAULTS,
    ) -> None:
        """Read the wheels' angles (rad) at `time_ns`; a repeated reading has no effect."""
        if self._angles is None or self.time_ns is None:
            self._angles, self.time_ns = angles, time_ns
        if time_ns == self.time_ns:
            return
        radius = 1 + self._options.wheel_radius_error
        turned = [(now - last) * radius for now, last in zip(angles, self._angles, strict=True)]
        elapsed_s = (time_ns - self.time_ns) / 1e9
        separation = 1 + self._options.wheel_separation_error
        if faults is not NO_ODOMETRY_FAULTS:
            left, right = faults.left_radius_error, faults.right_radius_error
            turned = [
                each * (1 + (left if is_left else right))
                for each, is_left in zip(turned, self._is_left, strict=True)
            ]
            separation *= 1 + faults.separation_error
        ahead, aside, turn = (sum(map(mul, row, turned)) for row in self._motion)
        turn /= separation
        if faults is not NO_ODOMETRY_FAULTS:
            ahead += faults.drift * elapsed_s
            turn += math.radians(faults.turn_drift) * elapsed_s
        middle, chord = self.yaw + turn / 2, _sinc(turn / 2)
        cos, sin = math.cos(middle), math.sin(middle)
        self.x += chord * (cos * ahead - sin * aside)
        self.y += chord * (sin * ahead + cos * aside)
        self.yaw = wrapped(self.yaw + turn)
        self.linear, self.lateral = ahead / elapsed_s, aside / elapsed_s
        self.angular = turn / elapsed_s
        self._angles, self.time_ns = angles, time_ns


def wrapped(angle: float) -> float:
    """Return an angle (rad) in (-pi, pi]."""
    return math.pi - (math.pi - angle) % math.tau


def _sinc(angle: float) -> float:
    return math.sin(angle) / angle if abs(angle) > 1e-9 else 1.0


class Encoders:
    """Angles of the wheels since the start, rad.

    `slip` is the mean share of a wheel's turning without motion. Between two readings it varies by
    half of it (1 sigma), independently for each wheel, and is never negative.
    """

    def __init__(self, slip: float, seed: int, prefix: str = "", wheels: int = 2) -> None:
        self._slip = slip
        self._noise = Noise(seed, f"{prefix}encoders", wheels)
        self.start(*[0.0] * wheels)

    def start(self, *angles: float) -> None:
        """Count from these angles on, as at the first time."""
        self._index = 0
        self._start = self._last = angles
        self._in_vain = (0.0,) * len(angles)

    def read(self, *angles: float) -> float:
        """Read the true angles. Return how far all wheels have turned together, rad."""
        turned = [now - last for now, last in zip(angles, self._last, strict=True)]
        self._last = angles
        if self._slip:
            shares = self._slip * (1 + self._noise.at(self._index) / 2).clip(min=0.0)
            self._in_vain = tuple(
                vain + each * float(share)
                for vain, each, share in zip(self._in_vain, turned, shares, strict=True)
            )
            self._index += 1
        return sum(map(abs, turned))

    def angles(self, *angles: float) -> tuple[float, ...]:
        """Return the reading of the encoders at the true angles."""
        places = zip(angles, self._start, self._in_vain, strict=True)
        return tuple([now - start + vain for now, start, vain in places])
