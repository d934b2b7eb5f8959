"""Turn on the spot by an angle without hitting an obstacle; and the same as Nav2's Spin."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from action_servers.core.action import Action, FeedbackRanges
from action_servers.core.limits import (
    ANGULAR,
    OVERSHOOT_DEG,
    SLOWEST_TURN,
    Limits,
    NumberLimit,
    around,
    parameter,
)
from action_servers.core.maneuver import SUCCEEDED, Fields, Finished, Observation
from action_servers.core.progress import ChangedFields
from action_servers.core.tuning import Tuning
from action_servers.driving.drive import Drive
from action_servers.driving.recoveries import ALLOWANCE, Allowance, Codes
from bt_mission.base.geometry import Twist2D
from bt_mission.base.parameters import number
from bt_mission.base.stamps import NS, to_ns
from bt_mission.robots.model import RobotModel


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnTuning(Tuning):
    """Of rotations by an angle."""

    turn_tolerance: float = number(
        1.0, (0.1, 10.0), "Error with which a rotation counts as done once the robot stands, deg."
    )
    turn_limit: float = number(
        3600.0, (1.0, 36000.0), "Largest angle of turn and spin that is accepted, deg; ten turns."
    )
    spin_velocity: float = number(
        1.0, (0.05, 3.0), "Speed of spin, rad/s; the fastest of Nav2's (0.4 to 1.0)."
    )
    default_turn_velocity: float = number(
        1.0,
        (SLOWEST_TURN, 3.0),
        "Speed of a turn whose goal asks for 0, rad/s, at most the robot's. The default is the "
        "upper end of what Nav2's spin behaviour turns at (0.4 to 1.0).",
    )


TURNING = TurnTuning()
"""The defaults."""


SPIN = Codes(unknown=700, timeout=701, tf_error=702, collision_ahead=703)


def turn_limits(robot: RobotModel, tuning: TurnTuning) -> Limits:
    """Return the limits of `turn`. An angle of 0 succeeds without moving."""
    angle, fastest = tuning.turn_limit, robot.max_angular_velocity
    return (
        NumberLimit(
            field="angle", low=-angle, high=angle, unit="deg", source=parameter("turn_limit")
        ),
        NumberLimit(
            field="angular_velocity",
            low=SLOWEST_TURN,
            high=fastest,
            unit="rad/s",
            source=ANGULAR,
            zero="the server's default",
        ),
    )


def turn_feedback(goal: Any) -> FeedbackRanges:
    """Return the ranges of the angles."""
    turned = around(goal.angle, OVERSHOOT_DEG)
    return {"current_angle": turned, "remaining_angle": turned}


def plan(
    goal: Any,
    _now: Observation,
    robot: RobotModel,
    tuning: TurnTuning = TURNING,
) -> Turn:
    """Return the maneuver for a goal of `turn`."""
    speed = goal.angular_velocity or min(tuning.default_turn_velocity, robot.max_angular_velocity)
    return Turn(math.radians(goal.angle), speed, robot, tuning)


class Turn:
    """Turns by `angle` (radians, left positive, not wrapped) at up to `speed` (rad/s).

    It slows down near the end, and finishes once it stands at the angle.
    """

    needs_base = True

    def __init__(
        self, angle: float, speed: float, robot: RobotModel, tuning: TurnTuning = TURNING
    ) -> None:
        self._angle = angle
        self._speed = speed
        self._drive = Drive(robot, tuning)
        self._tolerance = math.radians(tuning.turn_tolerance)
        self._resting = False
        self._changed = ChangedFields()

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
        twist = self._drive.turn_towards(now, self._angle, self._speed)
        if twist is not None:
            return twist
        self._resting = True
        return self._drive.rest(now) or SUCCEEDED

    def feedback(self) -> Fields | None:
        """Return the angle turned and the remaining one, when they have changed."""
        turned, remaining = self._drive.yaw, self._angle - self._drive.yaw
        return self._changed.of(
            {"current_angle": math.degrees(turned), "remaining_angle": math.degrees(remaining)}
        )

    def result(self) -> Fields:
        """Return the angle turned, degrees."""
        return {"angle_turned": math.degrees(self._drive.yaw)}


TURN = Action(
    name="turn",
    type="bt_mission_interfaces/action/Turn",
    needs=("base", "scan", "odometry"),
    example={"angle": 720.0},
    plan=plan,
    tuning=TURNING,
    limits=turn_limits,
    feedback=turn_feedback,
)


def spin_limits(_robot: RobotModel, tuning: TurnTuning) -> Limits:
    """Return the limits of `spin`."""
    angle = math.radians(tuning.turn_limit)
    source = parameter("turn_limit")
    return (
        NumberLimit(field="target_yaw", low=-angle, high=angle, unit="rad", source=source),
        ALLOWANCE,
    )


def spin_feedback(goal: Any) -> FeedbackRanges:
    """Return the range of the angle."""
    return {"angular_distance_traveled": around(goal.target_yaw, math.radians(OVERSHOOT_DEG))}


def plan_spin(
    goal: Any, _now: Observation, robot: RobotModel, tuning: TurnTuning = TURNING
) -> Spin:
    """Return the maneuver for a goal of `spin`."""
    return Spin(goal.target_yaw, to_ns(goal.time_allowance) / NS, robot, tuning)


class Spin:
    """A :class:`Turn` with Nav2's fields and codes."""

    needs_base = True

    def __init__(
        self, angle: float, allowance_s: float, robot: RobotModel, tuning: TurnTuning = TURNING
    ) -> None:
        speed = min(tuning.spin_velocity, robot.max_angular_velocity)
        self._turn = Turn(angle, speed, robot, tuning)
        self._allowance = Allowance(allowance_s, SPIN)
        self._changed = ChangedFields()

    def step(self, now: Observation) -> Twist2D | Finished:
        """Turn on, or end."""
        late = self._allowance.late(now)
        answer = self._turn.step(now)
        if isinstance(answer, Finished):
            return replace(answer, error_code=SPIN.of(answer.error_code))
        return late or answer

    def feedback(self) -> Fields | None:
        """Return the angle turned, when it has changed."""
        return self._changed.of({"angular_distance_traveled": self._turn.yaw})

    def result(self) -> Fields:
        """Return the time used."""
        return {"total_elapsed_time": self._allowance.elapsed_s}


SPIN_ACTION = Action(
    name="spin",
    type="nav2_msgs/action/Spin",
    needs=("base", "scan", "odometry"),
    example={"target_yaw": 12.0},
    plan=plan_spin,
    tuning=TURNING,
    limits=spin_limits,
    codes=SPIN.numbers,
    feedback=spin_feedback,
)
