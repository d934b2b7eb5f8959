"""Coordinate frames by name, and the pose of one in another."""

from __future__ import annotations

import math
from dataclasses import dataclass

MAP = "map"
ODOM = "odom"
BASE_FOOTPRINT = "base_footprint"
BASE_LINK = "base_link"

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

_AHEAD: Quaternion = (0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class FramePose:
    """A frame in its parent: translation in m, rotation as x, y, z, w."""

    parent: str
    child: str
    translation: Vector
    rotation: Quaternion = _AHEAD


def map_to_odom(pose: Vector, odom: Vector) -> Vector:
    """Return the odometry frame's pose in the map (m, m, rad), from the base's pose in both."""
    yaw = pose[2] - odom[2]
    cos, sin = math.cos(yaw), math.sin(yaw)
    x = pose[0] - (cos * odom[0] - sin * odom[1])
    y = pose[1] - (sin * odom[0] + cos * odom[1])
    return x, y, yaw


def on_map(to_odom: Vector, odom: Vector) -> Vector:
    """Return the pose of the base in the map (m, m, rad): `map_to_odom` the other way round."""
    x, y, yaw = to_odom
    cos, sin = math.cos(yaw), math.sin(yaw)
    return x + cos * odom[0] - sin * odom[1], y + sin * odom[0] + cos * odom[1], yaw + odom[2]
