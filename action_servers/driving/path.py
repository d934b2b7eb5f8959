"""Whether the way of a constant velocity is free: for maneuvers that do not steer."""

from __future__ import annotations

import math

from action_servers.core.clearance import Points, obstacle_points
from action_servers.core.guard import footprint, free_angle, free_distance
from action_servers.core.maneuver import Observation, Scan
from action_servers.core.tuning import TUNING, Tuning
from bt_mission.core.geometry import Twist2D
from bt_mission.core.robot.model import RobotModel

_CREEP = 1e-6


class Way:
    """The room that the newest scan leaves to the hull.

    What is needed is the way until the base stands: at the velocity until the next command takes
    effect, counted from the scan, then braking at half of what the base can do, then a margin.
    """

    def __init__(self, robot: RobotModel, tuning: Tuning = TUNING) -> None:
        self._robot = robot
        self._tuning = tuning
        self._body = footprint(robot)
        self._scan: Scan | None = None
        self._points: Points | None = None

    def blocked(self, now: Observation, twist: Twist2D) -> str | None:
        """Return what is wrong with driving on at `twist`, or None when the way is free."""
        scan = now.scan
        if scan is None:
            return "nothing is seen of the way"
        points = self._look(scan)
        delay_s = 1.0 / self._robot.control_rate + max(0.0, now.time_s - scan.stamp_s)
        if abs(twist.linear) > _CREEP:
            braking_s = abs(twist.linear) / self._robot.max_linear_acceleration
            needed = abs(twist.linear) * (delay_s + braking_s) + self._tuning.stop_margin
            horizon = math.copysign(needed, twist.linear)
            room = free_distance(points, self._body, twist.angular / twist.linear, horizon)
            side = "ahead" if twist.linear > 0.0 else "behind"
            return None if room >= needed else f"an obstacle stands in the way, {side}"
        braking_s = abs(twist.angular) / self._robot.max_angular_acceleration
        needed = abs(twist.angular) * (delay_s + braking_s)
        needed += math.radians(self._tuning.turn_margin)
        room = free_angle(points, self._body, math.copysign(needed, twist.angular))
        side = "left" if twist.angular > 0.0 else "right"
        return None if room >= needed else f"no room to turn {side}"

    def _look(self, scan: Scan) -> Points:
        if scan is not self._scan or self._points is None:
            self._scan = scan
            self._points = obstacle_points(scan, self._robot.lidar).T
        return self._points
