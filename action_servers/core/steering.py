"""The motions of a car: what it cannot drive becomes arcs that it can.

A car turns only while it drives. A turn on the spot becomes a turn in several strokes: ahead on the
sharpest arc, then back on the opposite one, both of which turn the base to the same side. A
stroke ends where the governor sees no room, or after :data:`STROKE_RAD`, so that the base stays
near its place. An arc that is too sharp becomes the sharpest one.
"""

from __future__ import annotations

import math

from action_servers.core.maneuver import Observation
from bt_mission.base.geometry import Twist2D, wrap
from bt_mission.robots.model import RobotModel

STROKE_RAD = 0.4
"""The turn of one stroke: with an arc of 0.74 m, the base stays within 0.3 m of its place."""

_AGAIN_S = 0.3
"""A turn that pauses for longer begins with a stroke ahead again."""


class Steering:
    """Replaces the twists that a car cannot drive. A step calls :meth:`arc` once."""

    def __init__(self, robot: RobotModel) -> None:
        self._sharpest = robot.drive.max_curvature
        self._fastest = robot.max_linear_velocity
        self._direction = 1.0
        self._began: float | None = None
        self._last_s = -math.inf

    def arc(self, wanted: Twist2D, now: Observation) -> Twist2D:
        """Return a twist that the car can drive instead of a wanted one."""
        linear, angular = wanted.linear, wanted.angular
        if linear or not angular:
            most = self._sharpest * abs(linear)
            if abs(angular) <= most:
                return Twist2D(linear, angular)
            return Twist2D(linear, math.copysign(most, angular))
        yaw = 0.0 if now.odom is None else now.odom.yaw
        if now.time_s - self._last_s > _AGAIN_S:
            self._direction, self._began = 1.0, None
        self._last_s = now.time_s
        if self._began is None:
            self._began = yaw
        elif abs(wrap(yaw - self._began)) >= STROKE_RAD:
            self.reverse(now)
        return self._stroke(angular, now.speed_limit)

    def reverse(self, now: Observation) -> None:
        """Begin a stroke in the other direction."""
        self._direction, self._began = -self._direction, 0.0 if now.odom is None else now.odom.yaw

    def _stroke(self, angular: float, speed_limit: float) -> Twist2D:
        speed = min(abs(angular) / self._sharpest, self._fastest, speed_limit)
        return Twist2D(self._direction * speed, math.copysign(speed * self._sharpest, angular))
