"""Nav2's BackUp and DriveOnHeading: drive straight by a distance."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from action_servers.core.action import Action, FeedbackRanges
from action_servers.core.limits import (
    LINEAR,
    OVERSHOOT_M,
    SLOWEST_DRIVE,
    Limits,
    NumberLimit,
    around,
    parameter,
)
from action_servers.core.maneuver import SUCCEEDED, Fields, Finished, Observation, Reason, Refusal
from action_servers.core.progress import ChangedFields
from action_servers.core.tuning import Tuning
from action_servers.driving.drive import ARRIVED_WITHIN, Drive
from action_servers.driving.recoveries import ALLOWANCE, Allowance, Codes
from bt_mission.base.geometry import Twist2D
from bt_mission.base.parameters import number
from bt_mission.base.stamps import NS, to_ns
from bt_mission.robots.model import RobotModel

BACK_UP = Codes(unknown=710, timeout=711, tf_error=712, invalid_input=713, collision_ahead=714)
DRIVE_ON_HEADING = Codes(
    unknown=720, timeout=721, tf_error=722, collision_ahead=723, invalid_input=724
)


@dataclass(frozen=True, slots=True, kw_only=True)
class WayTuning(Tuning):
    """Of drives by a distance."""

    distance_limit: float = number(
        100.0, (0.1, 10000.0), "Longest way of back_up and drive_on_heading that is accepted, m."
    )


WAYS = WayTuning()
"""The defaults."""


def limits(robot: RobotModel, tuning: WayTuning) -> Limits:
    """Return the limits of `backup` and `drive_on_heading`."""
    fastest, longest = robot.max_linear_velocity, tuning.distance_limit
    source = parameter("distance_limit")
    return (
        NumberLimit(field="target.x", low=-longest, high=longest, unit="m", source=source),
        NumberLimit(field="speed", low=-fastest, high=fastest, unit="m/s", source=LINEAR),
        ALLOWANCE,
    )


def misfit(goal: Any, robot: RobotModel, *, backwards: bool) -> str | None:
    """Return why a goal is aborted at once, or None.

    Backwards, the signs of distance and speed do not matter, as in Nav2. The plan refuses numbers
    that are not finite. A base that slides also drives to a point aside, at a positive speed.
    """
    target, speed = goal.target, goal.speed
    if not math.isfinite(target.y + target.z):
        return None
    if target.y != 0.0 and target.z == 0.0 and robot.drive.slide_velocity and not backwards:
        if speed >= SLOWEST_DRIVE:
            return None
        return f"speed must be {SLOWEST_DRIVE:g} m/s or more, got {speed:g}"
    if target.y != 0.0 or target.z != 0.0:
        return f"target.y and target.z must be 0, got {target.y:g} and {target.z:g}"
    if not backwards and (target.x > 0.0) != (speed > 0.0):
        return f"target.x and speed must have one sign, got {target.x:g} m and {speed:g} m/s"
    if abs(speed) < SLOWEST_DRIVE and target.x != 0.0:
        shown = -abs(speed) if backwards else speed
        return f"speed must be {SLOWEST_DRIVE:g} m/s or more, got {shown:g}"
    return None


def feedback(goal: Any) -> FeedbackRanges:
    """Return the range of the distance."""
    way = math.hypot(goal.target.x, goal.target.y)
    return {"distance_traveled": around(way, OVERSHOOT_M)}


def plan_back_up(
    goal: Any, _now: Observation, robot: RobotModel, tuning: WayTuning = WAYS
) -> Straight | Refusal:
    """Return the maneuver for a goal; whatever the signs, the robot drives backwards."""
    return _plan(goal, -abs(goal.target.x), BACK_UP, robot, tuning)


def plan_drive_on_heading(
    goal: Any, _now: Observation, robot: RobotModel, tuning: WayTuning = WAYS
) -> Straight | Refusal:
    """Return the maneuver for a goal; the signs of distance and speed agree."""
    return _plan(goal, goal.target.x, DRIVE_ON_HEADING, robot, tuning)


def _plan(
    goal: Any, distance: float, codes: Codes, robot: RobotModel, tuning: WayTuning
) -> Straight | Refusal:
    if not math.isfinite(goal.target.y + goal.target.z):
        return Refusal("target must be finite")
    allowance = to_ns(goal.time_allowance) / NS
    return Straight(distance, abs(goal.speed), allowance, codes, robot, tuning, goal.target.y)


class Straight:
    """Drives by `distance` (metres, negative for backwards) at up to `speed` (m/s, positive).

    A base that slides also moves by `aside` metres to the left, without turning.

    It brakes in time to stop at the end, and before an obstacle on its way.
    """

    needs_base = True

    def __init__(
        self,
        distance: float,
        speed: float,
        allowance_s: float,
        codes: Codes,
        robot: RobotModel,
        tuning: WayTuning = WAYS,
        aside: float = 0.0,
    ) -> None:
        self._length = math.hypot(distance, aside)
        self._direction = math.copysign(1.0, distance)
        self._heading = (distance / self._length, aside / self._length) if aside else None
        self._speed = min(speed, robot.drive.slide_velocity) if aside else speed
        self._codes = codes
        self._drive = Drive(robot, tuning)
        self._allowance = Allowance(allowance_s, codes)
        self._changed = ChangedFields()

    def step(self, now: Observation) -> Twist2D | Finished:
        """Drive on, slow down, or end."""
        late = self._allowance.late(now)
        answer = self._drive.fault(now) or self._drive_on(now)
        if isinstance(answer, Finished):
            return replace(answer, error_code=self._codes.of(answer.error_code))
        return late or answer

    def feedback(self) -> Fields | None:
        """Return the distance driven, when it has changed."""
        return self._changed.of({"distance_traveled": self._drive.distance})

    def result(self) -> Fields:
        """Return the time used."""
        return {"total_elapsed_time": self._allowance.elapsed_s}

    def _drive_on(self, now: Observation) -> Twist2D | Finished:
        remaining = self._length - self._drive.advance(self._direction)
        if remaining <= ARRIVED_WITHIN:
            return self._drive.rest(now) or SUCCEEDED
        if now.held is not None and now.held.by is Reason.OBSTACLE:
            done = f"{self._drive.distance:.2f} of {self._length:.2f} m"
            return now.held.ended(f", after {done}")
        speed = self._drive.speed_ahead(now, remaining, self._speed)
        if self._heading is not None:
            return Twist2D(self._heading[0] * speed, 0.0, self._heading[1] * speed)
        return Twist2D(self._direction * speed, 0.0)


BACK_UP_ACTION = Action(
    name="backup",
    short="back_up",
    type="nav2_msgs/action/BackUp",
    needs=("base", "scan", "odometry"),
    example={"target": [1.5, 0.0, 0.0], "speed": 0.15},
    plan=plan_back_up,
    tuning=WAYS,
    limits=limits,
    misfit=partial(misfit, backwards=True),
    misfit_code=BACK_UP.invalid_input,
    codes=BACK_UP.numbers,
    feedback=feedback,
)

DRIVE_ON_HEADING_ACTION = Action(
    name="drive_on_heading",
    type="nav2_msgs/action/DriveOnHeading",
    needs=("base", "scan", "odometry"),
    example={"target": [1.5, 0.0, 0.0], "speed": 0.15},
    plan=plan_drive_on_heading,
    tuning=WAYS,
    limits=limits,
    misfit=partial(misfit, backwards=False),
    misfit_code=DRIVE_ON_HEADING.invalid_input,
    codes=DRIVE_ON_HEADING.numbers,
    feedback=feedback,
)
