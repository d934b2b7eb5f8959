"""The base's controller: limits, acceleration ramp, and a stop without commands.

Pure arithmetic, in place of the robot's firmware: a command is clipped to the limits of the model,
reached at limited acceleration, and holds for `command_timeout` times `command_timeout_factor`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from bt_mission.base.geometry import Twist2D
from bt_mission.robots.drives import AckermannDrive
from bt_mission.robots.model import RobotModel

_STRAIGHT = 1e-6
_STEERED_RAD = 0.1
"""A car drives off once its front wheels stand this near to the wanted angle, as a driver does."""


@dataclass
class DifferentialController:
    """Computes wheel speeds from commands, one physics step at a time."""

    robot: RobotModel
    step_s: float
    linear: float = 0.0
    """The present velocity command of the wheels, m/s."""
    angular: float = 0.0
    """The present turn rate command of the wheels, rad/s, left positive."""
    command_timeout_factor: float = 1.0
    """A command holds for this many times the command timeout."""
    _target_linear: float = field(default=0.0, init=False)
    _target_angular: float = field(default=0.0, init=False)
    _expires_ns: int = field(default=0, init=False)
    due_ns: float = field(default=math.inf, init=False)
    """From when on :meth:`step` has something new for the wheels, ns."""
    _powered: bool = field(default=True, init=False)

    def command(self, linear: float, angular: float, time_ns: int, lateral: float = 0.0) -> None:
        """Command a velocity (m/s, rad/s), for the command timeout from `time_ns` on.

        Of a velocity to the left (`lateral`, m/s) only bases that slide make use.

        A command from an earlier time holds for the rest of that time, if any.

        Raises ValueError if one of them is not finite; the last command then stays. Without power a
        command is ignored.
        """
        if not math.isfinite(linear + angular + lateral):
            wanted = Twist2D(linear, angular, lateral)
            raise ValueError(f"expected a finite velocity, got {wanted}")
        if not self._powered:
            return
        robot = self.robot
        self._target_linear = _clip(linear, robot.max_linear_velocity)
        self._target_angular = _clip(angular, robot.max_angular_velocity)
        self._expires_ns = time_ns + round(self.timeout_s * 1e9)
        self.due_ns = 0

    @property
    def timeout_s(self) -> float:
        """The time for which a command holds, s."""
        return self.robot.command_timeout * self.command_timeout_factor

    def switch(self, *, on: bool) -> None:
        """Give or take the motors' power. Either way the last command is forgotten."""
        self._powered = on
        self.linear = self.angular = self._target_linear = self._target_angular = 0.0
        self._expires_ns = 0
        self.due_ns = math.inf

    def step(self, time_ns: int) -> tuple[float, float]:
        """Take the step that begins at `time_ns`, if it is due.

        Returns the speeds of the left and the right wheel, rad/s.
        """
        if time_ns >= self._expires_ns:
            self._target_linear = self._target_angular = 0.0
        robot, step_s = self.robot, self.step_s
        self.linear = _toward(
            self.linear, self._target_linear, robot.max_linear_acceleration * step_s
        )
        self.angular = _toward(
            self.angular, self._target_angular, robot.max_angular_acceleration * step_s
        )
        if self.linear == self._target_linear and self.angular == self._target_angular:
            self.due_ns = self._expires_ns if self.linear or self.angular else math.inf
        wheels: Any = robot.drive
        across = self.angular * wheels.wheel_separation / 2
        return (self.linear - across) / wheels.wheel_radius, (
            self.linear + across
        ) / wheels.wheel_radius


@dataclass
class PlanarController(DifferentialController):
    """Computes the velocity of a base from commands: ahead, to the left, and turned to the left.

    A base that does not slide ignores commands to the left. A car steers: it turns only while it
    drives, no sharper than its front wheels allow, and these turn at a limited rate.
    """

    lateral: float = 0.0
    """The present velocity command to the left, m/s."""
    steering: float = field(default=0.0, init=False)
    """The present angle of a car's front wheels, rad, left positive."""
    _target_lateral: float = field(default=0.0, init=False)
    _moved: tuple[float, float, float] | None = field(default=None, init=False)

    def command(self, linear: float, angular: float, time_ns: int, lateral: float = 0.0) -> None:
        """Command a velocity; see :meth:`DifferentialController.command`."""
        super().command(linear, angular, time_ns, lateral)
        if self._powered:
            self._target_lateral = _clip(lateral, self.robot.drive.slide_velocity)

    def switch(self, *, on: bool) -> None:
        """Give or take the motors' power. Either way the last command is forgotten."""
        super().switch(on=on)
        self.lateral = self._target_lateral = 0.0
        self._moved = None

    def move(self, time_ns: int) -> tuple[float, float, float]:
        """Take the step that begins at `time_ns`; return m/s ahead, m/s to the left, rad/s.

        While nothing changes, the same object is returned.
        """
        if time_ns < self.due_ns and self._moved is not None:
            return self._moved
        if time_ns >= self._expires_ns:
            self._target_linear = self._target_angular = self._target_lateral = 0.0
        robot, drive = self.robot, self.robot.drive
        most = robot.max_linear_acceleration * self.step_s
        if isinstance(drive, AckermannDrive):
            is_steady = self._steer(drive, most)
        else:
            self.linear = _toward(self.linear, self._target_linear, most)
            self.lateral = _toward(self.lateral, self._target_lateral, most)
            self.angular = _toward(
                self.angular, self._target_angular, robot.max_angular_acceleration * self.step_s
            )
            is_steady = (self.linear, self.lateral, self.angular) == (
                self._target_linear,
                self._target_lateral,
                self._target_angular,
            )
        if is_steady:
            self.due_ns = self._expires_ns if time_ns < self._expires_ns else math.inf
        self._moved = self.linear, self.lateral, self.angular
        return self._moved

    def _steer(self, drive: AckermannDrive, most: float) -> bool:
        """Take a step of a car; return whether nothing changes until the next command."""
        wanted, turn = self._target_linear, self._target_angular
        angle = self.steering
        if abs(wanted) > _STRAIGHT:
            angle = math.atan(drive.wheelbase * turn / wanted)
        angle = _clip(angle, drive.max_steering_angle)
        self.steering = _toward(self.steering, angle, drive.max_steering_velocity * self.step_s)
        if abs(angle - self.steering) > _STEERED_RAD and (
            abs(self.linear) < most or (self.linear > 0) != (wanted > 0)
        ):
            wanted = 0.0
        self.linear = _toward(self.linear, wanted, most)
        self.angular = self.linear * math.tan(self.steering) / drive.wheelbase
        return self.linear == self._target_linear and self.steering == angle


def _clip(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))


def _toward(value: float, target: float, most: float) -> float:
    return value + _clip(target - value, most) if abs(target - value) > most else target
