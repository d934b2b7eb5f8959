"""Path following: regulated pure pursuit, after a turn towards the path and before one at its end.

Pure pursuit steers along the arc through a point of the path a little ahead, of curvature 2 sin(a)
/ d for a point at distance d and bearing a (R. C. Coulter, CMU-RI-TR-92-01). The speed decreases in
bends, near obstacles and before the end.

The way out of a place where the robot is too close to an obstacle to turn freely.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from action_servers.core.clearance import Footprint, free_angle, free_distance, into_frame
from action_servers.core.drive_limits import DriveLimits
from action_servers.core.grid import Bools, Floats, Survey
from action_servers.navigation.path import NAVIGATION, CostModel, NavigationTuning, Path
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


REACH_M = 1.0
"""The longest way out that is looked for, m."""

SPEED = 0.12
"""Speed on the way out, m/s."""

_STEP_M = 0.04
_TURN_STEP_RAD = math.pi / 12
_TURN_COST_M = 0.3
_ALIGNED_RAD = 0.05
_HEADING_GAIN = 2.0


@dataclass(frozen=True, slots=True)
class WayOut:
    """Turn to `yaw` (map frame, rad), then drive `distance` metres from `start`, or back if < 0."""

    start: Pose2D
    yaw: float
    distance: float


def way_out(
    pose: Pose2D, points: Floats, body: Footprint, survey: Survey, radius: float
) -> WayOut | None:
    """Find a turn and a straight drive to where the clearance is at least `radius`, or None.

    `points` are those of the scan, from the base, `n x 2` metres. The hull touches none of them on
    the way. The shortest way wins, a radian of turning counting as 0.3 m; straight before turning,
    left before right, forwards before backwards.
    """
    room = {side: free_angle(points, body, side * math.pi) for side in (1, -1)}
    best: WayOut | None = None
    least = math.inf
    for turn in range(int(math.pi / _TURN_STEP_RAD) + 1):
        angle = turn * _TURN_STEP_RAD
        if angle * _TURN_COST_M >= least:
            break
        for side in (1, -1) if turn else (1,):
            if angle > room[side]:
                continue
            facing = Pose2D(pose.x, pose.y, wrap(pose.yaw + side * angle))
            turned = into_frame(Pose2D(0.0, 0.0, side * angle), points)
            distance = _straight_out(facing, turned, body, survey, radius)
            if distance is not None and abs(distance) + angle * _TURN_COST_M < least:
                least = abs(distance) + angle * _TURN_COST_M
                best = WayOut(pose, facing.yaw, distance)
    return best


def _straight_out(
    facing: Pose2D, points: Floats, body: Footprint, survey: Survey, radius: float
) -> float | None:
    distances = np.arange(1, int(REACH_M / _STEP_M) + 1) * _STEP_M
    ways: list[float] = []
    for sign in (1, -1):
        x = facing.x + sign * distances * math.cos(facing.yaw)
        y = facing.y + sign * distances * math.sin(facing.yaw)
        out = np.flatnonzero(survey.clearance_at(np.column_stack((x, y))) >= radius)
        if not out.size:
            continue
        distance = float(distances[out[0]])
        if free_distance(points, body, 0.0, sign * distance) >= distance:
            ways.append(sign * distance)
    return min(ways, key=abs, default=None)


class Escape:
    """Drives a way out."""

    def __init__(self, way: WayOut, limits: DriveLimits) -> None:
        self._way = way
        self._limits = limits
        self._aligned = False

    def remaining(self, pose: Pose2D) -> float:
        """Distance still to drive, m."""
        way = self._way
        travelled = (pose.x - way.start.x) * math.cos(way.yaw)
        travelled += (pose.y - way.start.y) * math.sin(way.yaw)
        return max(0.0, abs(way.distance) - travelled * math.copysign(1.0, way.distance))

    def steer(self, pose: Pose2D) -> Twist2D | None:
        """Return the wanted twist, or None when out."""
        error = wrap(self._way.yaw - pose.yaw)
        if not self._aligned:
            self._aligned = abs(error) <= _ALIGNED_RAD
            if not self._aligned:
                return Twist2D(0.0, self._limits.spin(error))
        remaining = self.remaining(pose)
        if remaining <= 0.0:
            return None
        speed = min(SPEED, self._limits.approach(remaining) + 0.02)
        return Twist2D(math.copysign(speed, self._way.distance), _HEADING_GAIN * error)
