"""The clearance between a scan and the robot's hull.

Points are in the frame of the base (metres; x forward, y left, origin below the middle of the
axle). The hull is a rectangle around the robot with its wheels.

A ray counts as an obstacle only if its range is a finite number within the limits of the lidar. Inf
(nothing there), NaN (no measurement), 0.0 (no measurement of the LDS-01) and values outside the
limits are not obstacles.

The distances that the governor keeps, m. Those that are a choice are parameters.

`stop_margin` and `turn_margin` of the servers (`core/tuning.py`) are added to `HULL_M`.

The distance that the robot's hull can move before it touches a point of the scan.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache, reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from action_servers.core.maneuver import Observation, Scan
from bt_mission.base.geometry import Pose2D, Twist2D
from bt_mission.robots.body import Hull
from bt_mission.robots.model import LidarModel, RobotModel

NOISE_M = 0.03
"""The largest error of a ray: three standard deviations (0.01 m in ROBOTIS's simulation)."""

HULL_M = 0.01
"""Between the hull and a point that must not be touched: one standard deviation of a ray. The
circle that the hull sweeps has none: a path keeps only the circle free, so that noise would stop
every turn.
"""

ESCAPE_M = HULL_M + 0.02
"""The same on the way out of the way of what moves, where nobody aims: twice the precision of an
LDS-01 more (10 mm, ROBOTIS e-manual)."""

MOVING_M = 0.08
"""Between the hull and a moving obstacle, of which only the front is seen."""

STROKE_M = 0.04
"""Around the hull in a stroke of a car that turns, where there is as much room: its corners sweep
outside of its path."""


Points = npt.NDArray[np.float64]
Ranges = npt.NDArray[np.float32]
Reals = npt.NDArray[np.floating[Any]]


@dataclass(frozen=True, slots=True)
class ObstaclePoint:
    """A point of an obstacle, metres in the frame of the base, and its `gap` to the hull."""

    gap: float
    x: float
    y: float


def obstacle_points(scan: Scan, lidar: LidarModel) -> Points:
    """Return what the scan hit as an array of shape (2, n): x and y in the frame of the base."""
    return _points(scan, max(scan.range_min, lidar.min_range), lidar.x, lidar.y)


@lru_cache(maxsize=32)
def _points(scan: Scan, nearest: float, x: float, y: float) -> Points:
    ranges = scan.ranges
    # NaN compares false, so it drops out here as inf does.
    hit = (ranges >= nearest) & (ranges <= scan.range_max)
    reach = ranges[hit].astype(np.float64)
    directions = _directions(len(ranges), scan.angle_min, scan.angle_increment)[:, hit]
    points: Points = directions * reach
    points[0] += x
    points[1] += y
    points.flags.writeable = False  # shared by all users of this scan
    return points


@lru_cache(maxsize=8)
def _directions(rays: int, angle_min: float, angle_increment: float) -> Points:
    angles = angle_min + angle_increment * np.arange(rays)
    directions = np.stack([np.cos(angles), np.sin(angles)])
    directions.flags.writeable = False  # shared by every scan of this geometry
    return directions


def ray_towards(scan: Scan, bearings: Reals) -> tuple[npt.NDArray[np.intp], bool]:
    """Return the ray nearest to each bearing, rad from the first, and whether they cover 360°.

    An index may be beyond the last ray. If the rays cover 360°, it then counts on from the first.
    """
    step, count = abs(scan.angle_increment), len(scan.ranges)
    # A lidar that turns to the right counts its rays the other way round.
    turned = bearings if scan.angle_increment > 0.0 else -bearings
    if turned.size and np.abs(turned).max() < math.tau:
        turned = np.where(turned < 0.0, turned + math.tau, turned)  # faster than mod
    else:
        turned = np.mod(turned, math.tau)
    return np.rint(turned / step).astype(np.intp), abs(count * step - math.tau) < 1.5 * step


def of_nearest_rays(scan: Scan, values: Ranges, bearings: Reals) -> Ranges:
    """Return the value of the ray nearest to each bearing, rad from the first; 0 beyond the last.

    `values` has one for each ray of the scan.
    """
    ray, whole_turn = ray_towards(scan, bearings)
    if whole_turn:
        return values.take(ray, mode="wrap")
    return np.append(values, np.float32(0.0)).take(ray, mode="clip")


def ahead(points: Points, hull: Hull, side_margin: float = 0.02) -> ObstaclePoint | None:
    """Return the obstacle that a straight drive meets first, or None if the way is free.

    It is in the width that the hull sweeps, with `side_margin` metres added to each side for the
    noise of a ray and the drift of a straight drive. Its gap is the distance to drive until
    contact, never negative. Its place is the middle of the points that are as near as the nearest
    point except for noise, so that a wall straight ahead is not placed to the side of its noisiest
    ray.
    """
    x, y = points
    in_the_way = (x > 0.0) & (np.abs(y) <= hull.half_width + side_margin)
    x, y = x[in_the_way], y[in_the_way]
    if not x.size:
        return None
    # Reductions of ufuncs: the methods of arrays, and `mean`, take several calls each.
    nearest = float(np.minimum.reduce(x))
    as_near = x <= nearest + NOISE_M
    x, y = x[as_near], y[as_near]
    middle_x, middle_y = np.add.reduce(x) / x.size, np.add.reduce(y) / y.size
    return ObstaclePoint(max(0.0, nearest - hull.front), float(middle_x), float(middle_y))


def nearest_in_front(points: Points, hull: Hull) -> ObstaclePoint | None:
    """Return the obstacle nearest to the hull among all within 90 degrees of straight ahead."""
    x, y = points
    if not (x > 0.0).any():
        return None
    beside = np.maximum(np.abs(y) - hull.half_width, 0.0)
    gaps = np.where(x > 0.0, np.hypot(np.maximum(x - hull.front, 0.0), beside), np.inf)
    index = int(np.argmin(gaps))
    return ObstaclePoint(float(gaps[index]), float(x[index]), float(y[index]))


def pose_at(now: Observation, stamp_s: float) -> Pose2D:
    """Return the pose of the base at a time near that of odometry, in the odometry frame."""
    odom, velocity = now.odom or Pose2D(0.0, 0.0, 0.0), now.velocity or Twist2D()
    elapsed_s = stamp_s - now.odom_stamp_s
    yaw = odom.yaw + elapsed_s * velocity.angular
    way, aside = elapsed_s * velocity.linear, elapsed_s * velocity.lateral
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return Pose2D(odom.x + way * cosine - aside * sine, odom.y + way * sine + aside * cosine, yaw)


def into_frame(pose: Pose2D, points: Points) -> Points:
    """Return `n x 2` points of the frame of `pose`, as seen from `pose`."""
    cosine, sine = math.cos(pose.yaw), math.sin(pose.yaw)
    across, along = points[:, 0] - pose.x, points[:, 1] - pose.y
    return pairs(cosine * across + sine * along, cosine * along - sine * across)


def out_of_frame(pose: Pose2D, points: Points) -> Points:
    """Return `n x 2` points, as seen from `pose`, in the frame of `pose`."""
    cosine, sine = math.cos(pose.yaw), math.sin(pose.yaw)
    forward, left = points[:, 0], points[:, 1]
    return pairs(pose.x + cosine * forward - sine * left, pose.y + sine * forward + cosine * left)


def pairs(x: Reals, y: Reals) -> Points:
    """Return points with these coordinates, `n x 2`, in a fifth of the time of `column_stack`.

    Its layout is that of `column_stack`, so that sums over it are of the same order.
    """
    points = np.empty((len(x), 2))
    points[:, 0], points[:, 1] = x, y
    return points


_STEP_M = 0.02
_STEP_RAD = 0.05
_DEEPER_M = 1e-4
_STRAIGHT = 1e-6


@dataclass(frozen=True, slots=True)
class Footprint:
    """The robot seen from above: a rectangle, and the circle that it sweeps when it turns.

    Metres from the middle of the axle; `rear` is negative. Corners of the rectangle outside the
    circle do not belong to the robot: the wheels are wider than the body, not longer. `edges` are
    those of a polygon instead of the rectangle around it: the direction outwards, and the distance
    of the edge.
    """

    front: float
    rear: float
    half_width: float
    turning_radius: float
    edges: tuple[tuple[float, float, float], ...] = ()

    def depth(self, forward: Points, left: Points) -> Points:
        """Return how deep points lie inside, in metres, or a negative number outside."""
        if self.edges:
            sides = reduce(np.minimum, (d - x * forward - y * left for x, y, d in self.edges))
        else:
            sides = np.minimum(
                np.minimum(self.front - forward, forward - self.rear),
                self.half_width - np.abs(left),
            )
        return np.minimum(sides, self.turning_radius - np.hypot(forward, left))

    def grown(self, margin: float) -> Footprint:
        """Return a footprint that is larger by `margin` metres on every side, not in its circle.

        A path keeps only the circle free, so a margin there would let noise stop every turn.
        """
        return Footprint(
            self.front + margin,
            self.rear - margin,
            self.half_width + margin,
            self.turning_radius,
            tuple((x, y, distance + margin) for x, y, distance in self.edges),
        )


def footprint(robot: RobotModel) -> Footprint:
    """Return the footprint of a robot."""
    hull, outline = robot.hull, robot.outline
    edges = []
    for (x, y), (x_2, y_2) in zip(outline, (*outline[1:], *outline[:1]), strict=True):
        length = math.hypot(x_2 - x, y_2 - y)
        out = (y_2 - y) / length, (x - x_2) / length
        edges.append((*out, out[0] * x + out[1] * y))
    return Footprint(hull.front, hull.rear, hull.half_width, robot.turning_radius, tuple(edges))


def free_distance(points: Points, body: Footprint, curvature: float, horizon: float) -> float:
    """Return how far the base can drive along an arc, up to `horizon`, all in metres.

    `points` are `n x 2`, seen from the base; `curvature` is in 1/m, left positive. A negative
    horizon is backwards; the result is positive. Points within the margin of the hull stop it only
    if it moves towards them.
    """
    if abs(curvature) < _STRAIGHT:
        if body.edges:
            return free_slide(points, body, 0.0 if horizon > 0.0 else math.pi, abs(horizon))
        return _free_straight(points, body, horizon)
    near = _within(points, body.turning_radius + abs(horizon))
    if not len(near):
        return abs(horizon)
    steps = max(abs(horizon) / _STEP_M, abs(horizon * curvature) / _STEP_RAD)
    along = np.linspace(0.0, horizon, max(1, math.ceil(steps)) + 1)
    turned = along * curvature
    x, y = np.sin(turned) / curvature, (1.0 - np.cos(turned)) / curvature
    return _first_touch(near, body, x, y, turned, abs(horizon))


def _free_straight(points: Points, body: Footprint, horizon: float) -> float:
    wide = body.grown(HULL_M)
    lead = wide.front if horizon > 0.0 else -wide.rear
    inside = lead - math.copysign(1.0, horizon) * points[:, 0]  # behind the leading edge
    beside = wide.half_width - np.abs(points[:, 1])
    met = (beside > np.maximum(inside, 0.0)) & (2.0 * inside < wide.front - wide.rear)
    return max(0.0, float(-inside[met].max(initial=-abs(horizon))))


def free_slide(points: Points, body: Footprint, direction: float, horizon: float) -> float:
    """Return how far the base can slide in a direction (rad, left positive), up to a horizon, m."""
    near = _within(points, body.turning_radius + horizon)
    if not len(near):
        return horizon
    along = np.linspace(0.0, horizon, max(1, math.ceil(horizon / _STEP_M)) + 1)
    x, y = along * math.cos(direction), along * math.sin(direction)
    return _first_touch(near, body, x, y, np.zeros_like(along), horizon)


def free_angle(points: Points, body: Footprint, horizon: float) -> float:
    """Return how far the base can turn in place, up to `horizon` radians, left positive.

    The result is positive for both directions.
    """
    near = _within(points, body.turning_radius)
    if not len(near):
        return abs(horizon)
    count = max(1, math.ceil(abs(horizon) / _STEP_RAD))
    turned = np.linspace(0.0, horizon, count + 1)
    still = np.zeros_like(turned)
    return _first_touch(near, body, still, still, turned, abs(horizon))


def _within(points: Points, reach: float) -> Points:
    return points[points[:, 0] ** 2 + points[:, 1] ** 2 < reach * reach]


def _first_touch(
    points: Points, body: Footprint, x: Points, y: Points, yaw: Points, horizon: float
) -> float:
    wide = body.grown(HULL_M)
    across = points[:, 0] - x[:, None]
    along = points[:, 1] - y[:, None]
    cosine, sine = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    depth = wide.depth(cosine * across + sine * along, cosine * along - sine * across)
    allowed = np.maximum(depth[0], 0.0)
    touching = (depth > allowed + _DEEPER_M).any(axis=1)
    if not touching.any():
        return horizon
    return horizon * (int(np.argmax(touching)) - 1) / (len(x) - 1)
