"""Measure the distance that the robot drives in a time, whatever drives it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_servers.core.action import Action, PublishedTopic
from action_servers.core.limits import UNBOUNDED, duration_limit
from action_servers.core.maneuver import (
    SUCCEEDED,
    ZERO,
    ErrorCode,
    Fields,
    Finished,
    Observation,
    stale_odometry,
)
from action_servers.core.progress import Odometer, Ticker
from action_servers.core.tuning import TUNING, Tuning
from bt_mission.base.geometry import Twist2D
from bt_mission.robots.model import RobotModel


def plan(
    goal: Any,
    _now: Observation,
    robot: RobotModel,
    publish: Callable[[Fields], object],
    tuning: Tuning = TUNING,
) -> RecordDistance:
    """Return the maneuver for a goal; it publishes the distance, in metres, each second."""
    return RecordDistance(goal.seconds, robot, publish, tuning)


class RecordDistance:
    """Adds up odometry for `seconds` of ROS time, and publishes it once a second."""

    needs_base = False

    def __init__(
        self,
        seconds: int,
        robot: RobotModel,
        publish: Callable[[Fields], object],
        tuning: Tuning = TUNING,
    ) -> None:
        self._seconds = seconds
        self._publish = publish
        self._timeout_s = tuning.sensor_timeout
        self._odometer = Odometer(robot.max_linear_velocity, robot.max_angular_velocity)
        self._ticker = Ticker()
        self._is_due = False

    def step(self, now: Observation) -> Twist2D | Finished:
        """Take in odometry, or end."""
        fault = stale_odometry(now, self._timeout_s)
        if fault is not None:
            return fault
        jump = self._odometer.update(now)
        if jump is not None:
            return Finished("aborted", ErrorCode.NO_ODOMETRY, jump)
        self._ticker.update(now.time_s)
        self._is_due = self._ticker.take()
        if self._is_due:
            self._publish({"data": self._odometer.distance})
        return SUCCEEDED if self._ticker.has_reached(self._seconds) else ZERO

    def feedback(self) -> Fields | None:
        """Return the distance so far, once a second."""
        is_due, self._is_due = self._is_due, False
        return {"current_dist": self._odometer.distance} if is_due else None

    def result(self) -> Fields:
        """Return the distance, and whether the whole time was measured."""
        return {
            "status": self._ticker.has_reached(self._seconds),
            "total_dist": self._odometer.distance,
        }


RECORD_DISTANCE = Action(
    name="record_distance",
    type="bt_mission_interfaces/action/RecordDistance",
    needs=("odometry",),
    example={"seconds": 10},
    plan=plan,
    topic=PublishedTopic("total_distance", "std_msgs/msg/Float64"),
    limits=lambda _robot, tuning: (duration_limit("seconds", tuning),),
    feedback=lambda _goal: {"current_dist": UNBOUNDED},
)
