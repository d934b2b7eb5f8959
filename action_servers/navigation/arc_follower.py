"""Following the way of a car: each stroke in its direction, with a stop between two.

The curvature is that of the way, corrected by the distance from it and by the angle to it, so that
both decrease as those of a critically damped system over :data:`_LENGTH_M`.
"""

from __future__ import annotations

import math

import numpy as np

from action_servers.core.clearance import Footprint
from action_servers.core.drive_limits import DriveLimits
from action_servers.core.grid import Bools, Floats, Survey
from action_servers.navigation.arcs import KEPT_M, ArcWay, HullDiscs
from action_servers.navigation.path import NAVIGATION, NavigationTuning
from bt_mission.base.geometry import Pose2D, Twist2D, wrap

_LENGTH_M = 0.25
_WINDOW_M = 0.5
_CREEP = 0.03
_STRAYED_M = 0.02
"""A way counts as blocked where the hull has so much less room than it must keep, m."""

_SLOWEST_SHARE = 0.4
_CLOSE_M = 0.15


class ArcFollower:
    """Follows one way to its end, then turns to the yaw of the goal."""

    def __init__(
        self,
        way: ArcWay,
        goal_yaw: float,
        limits: DriveLimits,
        body: Footprint,
        survey: Survey,
        tuning: NavigationTuning = NAVIGATION,
    ) -> None:
        self._way = way
        self._goal_yaw = goal_yaw
        self._limits = limits
        self._discs = HullDiscs(body)
        self._tuning = tuning
        self._index = 0
        self._along = 0.0
        self._needed: Floats = np.minimum(KEPT_M, self._discs.room(way.poses, survey)) - _STRAYED_M
        self._checked: Survey = survey
        self._blocked: Floats = np.empty(0)
        self.off_path = 0.0

    @property
    def remaining(self) -> float:
        """Length of the way still to drive, m."""
        return max(0.0, self._way.length - self._driven)

    def seconds_left(self, pose: Pose2D, speed_limit: float) -> float:
        """Estimate the time still needed at most at `speed_limit` (m/s), s."""
        turn = 0.0 if self.remaining else abs(wrap(self._goal_yaw - pose.yaw))
        return self.remaining / min(self._limits.linear, speed_limit) + turn / self._limits.angular

    def blocked_in(self, survey: Survey) -> float:
        """Return the distance to the first pose ahead without room for the hull, m, or inf."""
        if survey is not self._checked:
            self._checked = survey
            tight: Bools = self._discs.room(self._way.poses, survey) < self._needed
            self._blocked = self._way.travelled[tight]
        ahead = self._blocked[self._blocked >= self._driven]
        return float(ahead[0]) - self._driven if ahead.size else math.inf

    def steer(self, pose: Pose2D, survey: Survey, speed: float, limit: float) -> Twist2D | None:
        """Return the wanted twist, or None at the goal.

        `speed` is the present one and `limit` the highest allowed, in m/s.
        """
        while self._index < len(self._way.strokes):
            path = self._way.strokes[self._index].path
            along, self.off_path = path.nearest(
                pose.x, pose.y, self._along, self._along + _WINDOW_M
            )
            self._along = max(self._along, along)
            if path.length - self._along > self._tuning.arrival_distance:
                return self._drive(pose, survey, limit)
            if abs(speed) > _CREEP:
                return Twist2D()
            self._index, self._along = self._index + 1, 0.0
        error = wrap(self._goal_yaw - pose.yaw)
        if abs(error) <= self._tuning.arrival_angle:
            return None
        return Twist2D(0.0, self._limits.spin(error))

    @property
    def _driven(self) -> float:
        strokes = self._way.strokes[: self._index]
        return sum(stroke.path.length for stroke in strokes) + self._along

    def _drive(self, pose: Pose2D, survey: Survey, limit: float) -> Twist2D:
        stroke = self._way.strokes[self._index]
        direction = stroke.direction
        x, y = stroke.path.at(self._along)
        yaw = stroke.yaw_at(self._along)
        bend = stroke.bend_at(self._along + self._limits.linear * _STEERING_S)
        aside = math.cos(yaw) * (pose.y - y) - math.sin(yaw) * (pose.x - x)
        error = wrap(pose.yaw - yaw)
        curvature = bend - aside / _LENGTH_M**2 - direction * 2.0 * error / _LENGTH_M
        left = stroke.path.length - self._along - self._tuning.arrival_distance
        linear = min(
            self._share(pose, survey) * self._limits.linear,
            max(_CREEP, self._limits.approach(left)),
            limit,
        )
        return Twist2D(direction * linear, direction * linear * curvature)

    def _share(self, pose: Pose2D, survey: Survey) -> float:
        room = self._discs.room_at(pose, survey, enough=_CLOSE_M)
        return min(1.0, max(_SLOWEST_SHARE, room / _CLOSE_M))


_STEERING_S = 0.1
"""How far ahead the bend is read: the time that the steering needs."""
