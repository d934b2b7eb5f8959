"""Turning on the spot to an angle, and not into an obstacle."""

from __future__ import annotations

import math

from action_servers.core.clearance import obstacle_points
from action_servers.core.guard import footprint, free_angle
from action_servers.core.maneuver import ErrorCode, Finished, Observation, Scan
from action_servers.core.tuning import TUNING, Tuning
from action_servers.driving.drive import DriveGuard
from bt_mission.core.geometry import Twist2D
from bt_mission.core.robot.model import RobotModel

ARRIVED_WITHIN = math.radians(0.3)
"""Distance to the target at which the robot is told to stop."""


class Rotation:
    """Turns the base so that the odometer of `drive` reads a target.

    The room to turn comes from the scan: the corners behind the wheels sweep a circle that is
    wider than the robot. Between two scans it counts on with odometry.
    """

    def __init__(self, drive: DriveGuard, robot: RobotModel, tuning: Tuning = TUNING) -> None:
        self._drive = drive
        self._robot = robot
        self._margin = math.radians(tuning.turn_margin)
        self._footprint = footprint(robot)
        self._seen: tuple[Scan | None, float] = (None, 0.0)
        self._end_of_room = math.inf

    def towards(self, now: Observation, target: float, speed: float) -> Twist2D | Finished | None:
        """Return the velocity towards `target` (radians) at up to `speed` (rad/s).

        None when the target is reached; the end of the goal when something stands in the way or
        the base does not turn.
        """
        remaining = target - self._drive.yaw
        if abs(remaining) <= ARRIVED_WITHIN:
            return None
        direction = math.copysign(1.0, remaining)
        self._look(now, direction)
        room = self._end_of_room - direction * self._drive.yaw
        if room <= 0.0:
            side = "left" if remaining > 0.0 else "right"
            return Finished(
                "aborted",
                ErrorCode.BLOCKED,
                f"no room to turn {side}: an obstacle stands within the circle of "
                f"{self._robot.turning_radius:.3f} m that the robot sweeps; "
                f"{math.degrees(abs(remaining)):.0f} deg were left",
            )
        rate = self._drive.rate_towards(now, min(abs(remaining), room), speed)
        return self._drive.command(now, Twist2D(0.0, math.copysign(rate, remaining)))

    def _look(self, now: Observation, direction: float) -> None:
        """Find the odometer's reading, times `direction`, at which the room to turn ends."""
        scan = now.scan
        if scan is None or self._seen == (scan, direction):
            return
        self._seen = (scan, direction)
        points = obstacle_points(scan, self._robot.lidar).T
        free = free_angle(points, self._footprint, direction * math.tau)
        if free >= math.tau:
            self._end_of_room = math.inf
            return
        rate = now.velocity.angular if now.velocity else 0.0
        yaw_at_scan = self._drive.yaw - rate * (now.odom_stamp_s - scan.stamp_s)
        self._end_of_room = direction * yaw_at_scan + free - self._margin
