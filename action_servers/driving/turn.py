"""Turn on the spot by an angle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Protocol

from action_servers.core.checks import refusal, stale
from action_servers.core.goal_limits import turn_limits
from action_servers.core.limits import faults
from action_servers.core.maneuver import SUCCEEDED, Finished, Observation, Refusal, Value
from action_servers.core.tuning import TUNING, Tuning
from action_servers.driving.drive import DriveGuard
from action_servers.driving.rotation import Rotation
from bt_mission.core.geometry import Twist2D
from bt_mission.core.robot.model import RobotModel

DEFAULT_SPEED = 1.0
"""rad/s, taken for 0: the upper end of what Nav2's spin behaviour turns at (0.4 to 1.0)."""


class TurnGoal(Protocol):
    """The goal fields of `bt_mission_interfaces/action/Turn`."""

    angle: float
    """How far to turn, degrees, left positive, not wrapped."""
    angular_velocity: float
    """Speed, rad/s; 0 for the default."""


def plan(
    goal: TurnGoal,
    now: Observation,
    robot: RobotModel,
    default_speed: float = DEFAULT_SPEED,
    tuning: Tuning = TUNING,
) -> Turn | Refusal:
    """Check a goal against the robot and what it sees. An angle of 0 succeeds without moving."""
    fastest = robot.max_angular_velocity
    speed = goal.angular_velocity
    wrong = faults(goal, turn_limits(robot, tuning))
    refused = refusal(*wrong, unready=stale(now, tuning.sensor_timeout))
    return refused or Turn(
        math.radians(goal.angle), speed or min(default_speed, fastest), robot, tuning
    )


class Turn:
    """Turns by `angle` (radians, left positive, not wrapped) at up to `speed` (rad/s).

    It slows down near the end, and is finished once it stands at the angle.
    """

    needs_base = True

    def __init__(
        self, angle: float, speed: float, robot: RobotModel, tuning: Tuning = TUNING
    ) -> None:
        self._angle = angle
        self._speed = speed
        self._drive = DriveGuard(robot, tuning)
        self._rotation = Rotation(self._drive, robot, tuning)
        self._tolerance = math.radians(tuning.turn_tolerance)
        self._resting = False
        self._told: float | None = None

    @property
    def yaw(self) -> float:
        """Angle turned so far, radians, left positive."""
        return self._drive.yaw

    def step(self, now: Observation) -> Twist2D | Finished:
        """Turn on, slow down, or end."""
        fault = self._drive.fault(now)
        if fault is not None:
            return fault
        if self._resting:
            rest = self._drive.rest(now)
            if rest is not None:
                return rest
            if abs(self._angle - self._drive.yaw) <= self._tolerance:
                return SUCCEEDED
            self._resting = False  # it slid past the end: turn back
        twist = self._rotation.towards(now, self._angle, self._speed)
        if twist is not None:
            return twist
        self._resting = True
        return self._drive.rest(now) or SUCCEEDED

    def feedback(self) -> Mapping[str, Value] | None:
        """Return the angle turned and the one that remains, when they have changed."""
        turned = self._drive.yaw
        if turned == self._told:
            return None
        self._told = turned
        return {
            "current_angle": math.degrees(turned),
            "remaining_angle": math.degrees(self._angle - turned),
        }

    def result(self) -> Mapping[str, Value]:
        """Return the angle turned, degrees."""
        return {"angle_turned": math.degrees(self._drive.yaw)}
