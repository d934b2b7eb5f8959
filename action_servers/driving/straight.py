"""Nav2's BackUp and DriveOnHeading: drive straight by a distance."""

from __future__ import annotations

import math
from typing import Protocol

from action_servers.core.checks import refusal, stale
from action_servers.core.goal_limits import straight_limits, straight_misfit
from action_servers.core.limits import faults
from action_servers.core.maneuver import (
    SUCCEEDED,
    ZERO,
    ErrorCode,
    Fields,
    Finished,
    Observation,
    Refusal,
)
from action_servers.core.ticker import News
from action_servers.core.tuning import TUNING, Tuning
from action_servers.driving.drive import ARRIVED_WITHIN, DriveGuard, Way
from action_servers.driving.recoveries import (
    BACK_UP,
    DRIVE_ON_HEADING,
    Allowance,
    Codes,
    Duration,
    Useless,
    seconds_of,
)
from bt_mission.core.geometry import Twist2D
from bt_mission.core.robot.model import RobotModel


class Point(Protocol):
    """A `geometry_msgs/Point`, metres."""

    x: float
    """Ahead."""
    y: float
    """To the left."""
    z: float
    """Up."""


class StraightGoal(Protocol):
    """The goal fields of `nav2_msgs/action/BackUp` and `DriveOnHeading`."""

    target: Point
    """How far to drive."""
    speed: float
    """How fast, m/s."""
    time_allowance: Duration
    """When to give up; 0 for never."""


def plan_back_up(
    goal: StraightGoal, now: Observation, robot: RobotModel, tuning: Tuning = TUNING
) -> Straight | Useless | Refusal:
    """Check a goal; whatever the signs, the robot drives backwards."""
    distance, speed = -abs(goal.target.x), -abs(goal.speed)
    return _plan(goal, (distance, speed), BACK_UP, now, robot, tuning)


def plan_drive_on_heading(
    goal: StraightGoal, now: Observation, robot: RobotModel, tuning: Tuning = TUNING
) -> Straight | Useless | Refusal:
    """Check a goal; the signs of distance and speed must agree."""
    return _plan(goal, (goal.target.x, goal.speed), DRIVE_ON_HEADING, now, robot, tuning)


def _plan(
    goal: StraightGoal,
    way: tuple[float, float],
    codes: Codes,
    now: Observation,
    robot: RobotModel,
    tuning: Tuning,
) -> Straight | Useless | Refusal:
    distance, speed = way
    allowance = seconds_of(goal.time_allowance)
    refused = refusal(
        *faults(goal, straight_limits(robot, tuning)),
        None if math.isfinite(goal.target.y + goal.target.z) else "target must be finite",
    )
    if refused is not None:
        return refused
    misfit = straight_misfit(goal, backwards=codes is BACK_UP)
    if misfit is not None:
        return Useless(codes.invalid_input, misfit)
    refused = refusal(unready=stale(now, tuning.sensor_timeout))
    return refused or Straight(distance, abs(speed), allowance, codes, robot, tuning)


class Straight:
    """Drives by `distance` (metres, negative for backwards) at up to `speed` (m/s, positive).

    It brakes in time to stand at the end, and before an obstacle that lies on its way.
    """

    needs_base = True

    def __init__(
        self,
        distance: float,
        speed: float,
        allowance_s: float,
        codes: Codes,
        robot: RobotModel,
        tuning: Tuning = TUNING,
    ) -> None:
        self._length = abs(distance)
        self._direction = math.copysign(1.0, distance)
        self._speed = speed
        self._codes = codes
        self._drive = DriveGuard(robot, tuning)
        self._way = Way(robot, tuning)
        self._allowance = Allowance(allowance_s, codes)
        self._news = News()

    def step(self, now: Observation) -> Twist2D | Finished:
        """Drive on, slow down, or end."""
        late = self._allowance.late(now)
        answer = self._drive.fault(now) or self._drive_on(now)
        if isinstance(answer, Finished):
            return self._codes.of(answer)
        return late or answer

    def feedback(self) -> Fields | None:
        """Return the distance driven, when it has changed."""
        return self._news.of({"distance_traveled": self._drive.distance})

    def result(self) -> Fields:
        """Return the time used."""
        return {"total_elapsed_time": self._allowance.elapsed_s}

    def _drive_on(self, now: Observation) -> Twist2D | Finished:
        remaining = self._length - self._drive.advance(self._direction)
        if remaining <= ARRIVED_WITHIN:
            return self._drive.rest(now) or SUCCEEDED
        speed = self._drive.speed_ahead(now, remaining, self._speed)
        twist = Twist2D(self._direction * speed, 0.0)
        obstacle = self._way.blocked(now, twist)
        if obstacle is not None and now.gives_way:
            return ZERO
        if obstacle is not None:
            reason = f"{obstacle}, after {self._drive.distance:.2f} of {self._length:.2f} m"
            return Finished("aborted", ErrorCode.BLOCKED, reason)
        return self._drive.command(now, twist)
