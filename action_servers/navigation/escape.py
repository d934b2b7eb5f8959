"""The way out of a place where the robot is too close to an obstacle to turn freely."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from action_servers.core.clearance import into_frame
from action_servers.core.drive_limits import DriveLimits
from action_servers.core.footprint import Footprint, free_angle, free_distance
from action_servers.core.grid import Floats, Survey
from bt_mission.base.geometry import Pose2D, Twist2D, wrap

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
