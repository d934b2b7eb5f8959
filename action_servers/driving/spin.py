"""Nav2's Spin: turn on the spot by an angle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from action_servers.core.checks import refusal, stale
from action_servers.core.goal_limits import spin_limits
from action_servers.core.limits import faults
from action_servers.core.maneuver import Finished, Observation, Refusal, Value
from action_servers.core.tuning import TUNING, Tuning
from action_servers.driving.recoveries import SPIN, Allowance, Duration, seconds_of
from action_servers.driving.turn import Turn
from bt_mission.core.geometry import Twist2D
from bt_mission.core.robot.model import RobotModel


class SpinGoal(Protocol):
    """The goal fields of `nav2_msgs/action/Spin`."""

    target_yaw: float
    """How far to turn, rad, left positive, not wrapped."""
    time_allowance: Duration
    """When to give up; 0 for never."""


def plan(
    goal: SpinGoal, now: Observation, robot: RobotModel, tuning: Tuning = TUNING
) -> Spin | Refusal:
    """Check a goal against what the robot sees."""
    wrong = faults(goal, spin_limits(tuning))
    refused = refusal(*wrong, unready=stale(now, tuning.sensor_timeout))
    return refused or Spin(goal.target_yaw, seconds_of(goal.time_allowance), robot, tuning)


class Spin:
    """A :class:`Turn` with Nav2's fields and codes."""

    needs_base = True

    def __init__(
        self, angle: float, allowance_s: float, robot: RobotModel, tuning: Tuning = TUNING
    ) -> None:
        speed = min(tuning.spin_velocity, robot.max_angular_velocity)
        self._turn = Turn(angle, speed, robot, tuning)
        self._allowance = Allowance(allowance_s, SPIN)
        self._told: float | None = None

    def step(self, now: Observation) -> Twist2D | Finished:
        """Turn on, or end."""
        late = self._allowance.late(now)
        answer = self._turn.step(now)
        if isinstance(answer, Finished):
            return SPIN.of(answer)
        return late or answer

    def feedback(self) -> Mapping[str, Value] | None:
        """Return the angle turned, when it has changed."""
        if self._turn.yaw == self._told:
            return None
        self._told = self._turn.yaw
        return {"angular_distance_traveled": self._turn.yaw}

    def result(self) -> Mapping[str, Value]:
        """Return the time used."""
        return {"total_elapsed_time": self._allowance.elapsed_s}
