"""Path following: regulated pure pursuit, after a turn towards the path and before one at its end.

Pure pursuit steers along the arc through a point of the path a little ahead, of curvature 2 sin(a)
/ d for a point at distance d and bearing a (R. C. Coulter, CMU-RI-TR-92-01). The speed decreases in
bends, near obstacles and before the end.
"""

from __future__ import annotations

import math

import numpy as np

from action_servers.core.drive_limits import DriveLimits
from action_servers.core.grid import Bools, Floats, Survey
from action_servers.navigation.path import CostModel, Path
from action_servers.navigation.tuning import NAVIGATION, NavigationTuning
from bt_mission.base.geometry import Pose2D, Twist2D, wrap

_THERE_M = 0.05
_LOOKAHEAD_M = 0.20
_LOOKAHEAD_S = 0.5
_WINDOW_M = 0.6
_TURN_FIRST_RAD = 0.9
_TURNED_RAD = 0.15
_BEND_RADIUS_M = 0.35
_SLOWEST_SHARE = 0.3
_CREEP = 0.02

_LOOKS = 5
"""Places at which a straight line to the point to steer for is looked at."""


class Follower:
    """Follows one path to its end, then turns to a yaw."""

    def __init__(
        self,
        path: Path,
        goal_yaw: float,
        limits: DriveLimits,
        cost: CostModel,
        survey: Survey,
        tuning: NavigationTuning = NAVIGATION,
    ) -> None:
        self._tuning = tuning
        self._path = path
        self._goal_yaw = goal_yaw
        self._limits = limits
        self._cost = cost
        self._along = 0.0
        self._turning = True
        end = path.points[-1]
        start = path.points[0]
        self._driven = math.hypot(end[0] - start[0], end[1] - start[1]) <= _THERE_M
        # A path may begin closer to obstacles than is allowed: that is known, and not a reason to
        # stop.
        needed = np.minimum(cost.radius - cost.margin, survey.clearance_at(path.points))
        self._needed: Floats = needed - cost.margin
        self._checked: Survey = survey
        self._blocked: Floats = np.empty(0)
        self.off_path = 0.0

    @property
    def remaining(self) -> float:
        """Length of path still to drive, m."""
        return 0.0 if self._driven else self._path.length - self._along

    def seconds_left(self, pose: Pose2D, speed_limit: float) -> float:
        """Estimate the time still needed at most at `speed_limit` (m/s), s."""
        turn = abs(wrap(self._goal_yaw - pose.yaw)) if self._driven else 0.0
        return self.remaining / min(self._limits.linear, speed_limit) + turn / self._limits.angular

    def blocked_in(self, survey: Survey) -> float:
        """Return the distance to the first point ahead that has become too tight, m, or inf."""
        if survey is not self._checked:
            self._checked = survey
            tight: Bools = survey.clearance_at(self._path.points) < self._needed
            self._blocked = self._path.travelled[tight]
        ahead = self._blocked[self._blocked >= self._along]
        return float(ahead[0]) - self._along if ahead.size and not self._driven else math.inf

    def steer(self, pose: Pose2D, survey: Survey, speed: float, limit: float) -> Twist2D | None:
        """Return the wanted twist, or None at the goal.

        `speed` is the present one and `limit` the highest allowed, in m/s.
        """
        if not self._driven:
            along, self.off_path = self._path.nearest(
                pose.x, pose.y, self._along, self._along + _WINDOW_M
            )
            self._along = max(self._along, along)
            if self._path.length - self._along > self._tuning.arrival_distance:
                return self._drive(pose, survey, speed, limit)
            self._driven = True
        error = wrap(self._goal_yaw - pose.yaw)
        if abs(error) <= self._tuning.arrival_angle:
            return None
        return Twist2D(0.0, self._limits.spin(error))

    def _drive(self, pose: Pose2D, survey: Survey, speed: float, limit: float) -> Twist2D:
        ahead_x, ahead_y = self._carrot(pose, survey, speed)
        bearing = wrap(math.atan2(ahead_y - pose.y, ahead_x - pose.x) - pose.yaw)
        self._turning = abs(bearing) > (_TURNED_RAD if self._turning else _TURN_FIRST_RAD)
        if self._turning:
            return Twist2D(0.0, self._limits.spin(bearing))
        gap = max(0.05, math.hypot(ahead_x - pose.x, ahead_y - pose.y))
        curvature = 2.0 * math.sin(bearing) / gap
        share = min(
            1.0,
            max(_SLOWEST_SHARE, 1.0 / max(1e-6, abs(curvature) * _BEND_RADIUS_M)),
            self._room(pose, survey),
        )
        left = self._path.length - self._along - self._tuning.arrival_distance
        linear = min(
            share * self._limits.linear,
            max(_CREEP, self._limits.approach(left)),
            limit,
        )
        return Twist2D(linear, curvature * linear)

    def _room(self, pose: Pose2D, survey: Survey) -> float:
        room = survey.clearance_of(pose.x, pose.y) - self._cost.radius
        full = 0.5 * (self._cost.comfort - self._cost.radius)
        return min(1.0, max(2 * _SLOWEST_SHARE, room / full))

    def _carrot(self, pose: Pose2D, survey: Survey, speed: float) -> tuple[float, float]:
        """Return the farthest point to steer for that does not cut a corner into an obstacle."""
        lookahead = _LOOKAHEAD_M + _LOOKAHEAD_S * speed
        here = survey.clearance_of(pose.x, pose.y)
        if here > self._cost.radius + lookahead:
            return self._beyond_end(self._path.at(self._along + lookahead), lookahead)
        needed = min(here, self._cost.radius - self._cost.margin) - 0.5 * self._cost.margin
        for share in (1.0, 0.6):
            point = self._path.at(self._along + share * lookahead)
            across, along = (point[0] - pose.x) / _LOOKS, (point[1] - pose.y) / _LOOKS
            if survey.clearance_of(*point) >= needed and all(
                survey.clearance_of(pose.x + count * across, pose.y + count * along) >= needed
                for count in range(1, _LOOKS)
            ):
                return self._beyond_end(point, share * lookahead)
        return self._beyond_end(self._path.at(self._along + 0.3 * lookahead), 0.3 * lookahead)

    def _beyond_end(self, point: tuple[float, float], lookahead: float) -> tuple[float, float]:
        # Near the end the point to steer for runs on straight ahead, or the arc would tighten.
        beyond = self._along + lookahead - self._path.length
        if beyond <= 0.0:
            return point
        direction = self._path.end_direction()
        return point[0] + beyond * math.cos(direction), point[1] + beyond * math.sin(direction)
