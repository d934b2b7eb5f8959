"""Drive at a constant velocity for a time."""

from __future__ import annotations

from typing import Any

from action_servers.core.action import Action
from action_servers.core.limits import ANGULAR, LINEAR, Limits, NumberLimit, duration_limit
from action_servers.core.maneuver import SUCCEEDED, Fields, Finished, Observation, Reason
from action_servers.core.progress import Ticker
from action_servers.core.tuning import TUNING, Tuning
from action_servers.driving.drive import Drive
from bt_mission.base.geometry import Twist2D
from bt_mission.robots.model import RobotModel

DEFAULT_SPEED = 0.1
"""m/s straight on, for a goal that gives no velocity."""


def limits(robot: RobotModel, tuning: Tuning) -> Limits:
    """Return the limits of `move`."""
    fastest, sharpest = robot.max_linear_velocity, robot.max_angular_velocity
    return (
        duration_limit("secs", tuning),
        NumberLimit(field="linear_velocity", low=-fastest, high=fastest, unit="m/s", source=LINEAR),
        NumberLimit(
            field="angular_velocity", low=-sharpest, high=sharpest, unit="rad/s", source=ANGULAR
        ),
    )


def plan(goal: Any, _now: Observation, robot: RobotModel, tuning: Tuning = TUNING) -> Move:
    """Return the maneuver for a goal."""
    twist = Twist2D(goal.linear_velocity, goal.angular_velocity)
    if twist == Twist2D():
        twist = Twist2D(DEFAULT_SPEED, 0.0)
    return Move(goal.secs, twist, robot, tuning)


class Move:
    """Drives at `twist` for exactly `secs` seconds of ROS time, then stops, and ends standing.

    It ends blocked, in time to stop before an obstacle on its way.
    """

    needs_base = True

    def __init__(
        self, secs: int, twist: Twist2D, robot: RobotModel, tuning: Tuning = TUNING
    ) -> None:
        self._secs = secs
        self._twist = twist
        self._drive = Drive(robot, tuning)
        self._ticker = Ticker()

    def step(self, now: Observation) -> Twist2D | Finished:
        """Drive on, or end."""
        fault = self._drive.fault(now)
        if fault is not None:
            return fault
        self._ticker.update(now.time_s)
        if self._ticker.has_reached(self._secs):
            return self._drive.rest(now) or SUCCEEDED
        if now.held is not None and now.held.by is Reason.OBSTACLE:
            return now.held.ended(f", after {self._done()}")
        return self._twist

    def feedback(self) -> Fields | None:
        """Return what is done so far, once a second."""
        if not self._ticker.take() or self._ticker.count > self._secs:
            return None
        return {"feedback": f"driving, {self._done()} so far"}

    def result(self) -> Fields:
        """Return real duration and distance."""
        return {"status": f"drove for {self._done()}"}

    def _done(self) -> str:
        elapsed_s = min(self._ticker.elapsed_s, self._secs)
        return f"{elapsed_s:.2f} of {self._secs} s, {self._drive.distance:.2f} m"


MOVE = Action(
    name="move",
    type="bt_mission_interfaces/action/Move",
    needs=("base", "scan", "odometry"),
    example={"secs": 10, "linear_velocity": 0.1},
    plan=plan,
    limits=limits,
)
