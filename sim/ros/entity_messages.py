"""Poses, states, volumes and tags of entities in messages, both ways."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from bt_mission.base.geometry import Pose2D, set_planar, yaw_of
from sim.entities import Corner, EntityState, InvalidPoseError
from sim.frames import MAP

EMPTY, BOX, CONVEX_HULL, SPHERE = range(4)
"""Types of simulation_interfaces/Bounds."""

_UNIT = 0.01
"""By how much the square of a quaternion's length may differ from 1."""

_LEVEL = 0.01
"""Metres above the floor, and radians of roll or pitch, that are ignored."""

_ZEROS = (0.0, 0.0, 0.0, 0.0)

_ALL = 1
"""The mode of simulation_interfaces/TagsFilter in which all tags must be there."""


def read_pose(pose: Any) -> Pose2D:
    """Return a pose on the floor. Raises InvalidPoseError for any other.

    The quaternion of a message that nobody has filled, all zeros, is no turn.
    """
    p, q = pose.position, pose.orientation
    numbers = (p.x, p.y, p.z, q.x, q.y, q.z, q.w)
    if not all(map(math.isfinite, numbers)):
        raise InvalidPoseError("expected a pose of finite numbers, got nan or inf")
    if abs(p.z) > _LEVEL:
        raise InvalidPoseError(f"expected z = 0, on the floor, got {p.z:g} m")
    turn = numbers[3:]
    if turn == _ZEROS:
        return Pose2D(p.x, p.y, 0.0)
    square = sum(min(abs(component), 1e9) ** 2 for component in turn)
    if abs(square - 1) > _UNIT:
        raise InvalidPoseError(
            f"expected a quaternion of length 1, got one of {math.sqrt(square):g}"
        )
    if math.hypot(q.x, q.y) > _LEVEL / 2:
        raise InvalidPoseError("expected a turn about the vertical axis only: all stands upright")
    return Pose2D(p.x, p.y, yaw_of(q))


def read_velocity(twist: Any) -> tuple[float, float, float]:
    """Return the velocity along x and y and the turn rate. Raises InvalidPoseError for others."""
    linear, angular = twist.linear, twist.angular
    numbers = (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
    if not all(map(math.isfinite, numbers)):
        raise InvalidPoseError("expected a twist of finite numbers, got nan or inf")
    if linear.z or angular.x or angular.y:
        raise InvalidPoseError("expected a twist along the floor and about the vertical axis only")
    return linear.x, linear.y, angular.z


def rotated(velocity: tuple[float, float, float], yaw: float) -> tuple[float, float, float]:
    """Return a velocity in the map that is given in a frame of that direction."""
    (vx, vy, turn), cos, sin = velocity, math.cos(yaw), math.sin(yaw)
    return vx * cos - vy * sin, vx * sin + vy * cos, turn


def passes(wanted: Any, tags: Sequence[str]) -> bool:
    """Return whether tags pass a TagsFilter: any of those asked for, or all of them."""
    if not wanted.tags:
        return True
    matches = [tag in tags for tag in wanted.tags]
    return all(matches) if wanted.filter_mode == _ALL else any(matches)


def fill_pose(message: Any, pose: Pose2D) -> None:
    """Fill a Pose."""
    set_planar(message.position, message.orientation, pose)


def fill_state(message: Any, state: EntityState) -> Any:
    """Fill an EntityState, and return it; the acceleration is not known, and stays 0."""
    message.header.frame_id = MAP
    fill_pose(message.pose, state.pose)
    linear, angular = message.twist.linear, message.twist.angular
    linear.x, linear.y, angular.z = state.velocity
    return message


def fill_box(message: Any, vector: Any, corners: tuple[Corner, Corner]) -> None:
    """Fill Bounds with a box: its upper and its lower corner. `vector` makes a Vector3."""
    message.type = BOX
    lower, upper = corners
    message.points = [vector(x=x, y=y, z=z) for x, y, z in (upper, lower)]


def around(state: EntityState, corners: tuple[Corner, Corner]) -> tuple[Corner, Corner]:
    """Return the lower and upper corner of a box along the axes of the map around an entity."""
    (x0, y0, z0), (x1, y1, z1) = corners
    pose = state.pose
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    at = [
        (pose.x + x * cos - y * sin, pose.y + x * sin + y * cos) for x in (x0, x1) for y in (y0, y1)
    ]
    xs, ys = [x for x, _ in at], [y for _, y in at]
    return (min(xs), min(ys), z0), (max(xs), max(ys), z1)


def overlaps(box: tuple[Corner, Corner], bounds: Any) -> bool:
    """Return whether a box overlaps with Bounds, a box or a sphere.

    Raises ValueError for invalid bounds.
    """
    points: list[Corner] = [(point.x, point.y, point.z) for point in bounds.points]
    if len(points) != 2 or not all(
        math.isfinite(coordinate) for point in points for coordinate in point
    ):
        raise ValueError(f"expected two points of finite numbers, got {len(points)} points")
    lower, upper = box
    first, second = points
    if bounds.type == SPHERE:
        near = [min(max(at, a), b) for at, a, b in zip(first, lower, upper, strict=True)]
        return math.dist(near, first) <= second[0]
    return all(
        min(a, b) <= high and max(a, b) >= low
        for a, b, low, high in zip(first, second, lower, upper, strict=True)
    )
