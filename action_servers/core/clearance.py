"""The clearance between a scan and the robot's hull.

Points are in the frame of the base (metres; x forward, y left, origin below the middle of the
axle). The hull is a rectangle around the robot with its wheels.

A ray counts as an obstacle only if its range is a finite number within the limits of the lidar. Inf
(nothing there), NaN (no measurement), 0.0 (no measurement of the LDS-01) and values outside the
limits are not obstacles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from action_servers.core.maneuver import Observation, Scan
from action_servers.core.margins import NOISE_M
from bt_mission.base.geometry import Pose2D, Twist2D
from bt_mission.robots.body import Hull
from bt_mission.robots.model import LidarModel

Points = npt.NDArray[np.float64]
Floats = npt.NDArray[np.float32]
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


def of_nearest_rays(scan: Scan, values: Floats, bearings: Reals) -> Floats:
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
