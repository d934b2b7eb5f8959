"""The distance that the robot's hull can move before it touches a point of the scan."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import reduce

import numpy as np

from action_servers.core.grid import Floats
from action_servers.core.margins import HULL_M
from bt_mission.robots.model import RobotModel

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

    def depth(self, forward: Floats, left: Floats) -> Floats:
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


def free_distance(points: Floats, body: Footprint, curvature: float, horizon: float) -> float:
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


def _free_straight(points: Floats, body: Footprint, horizon: float) -> float:
    wide = body.grown(HULL_M)
    lead = wide.front if horizon > 0.0 else -wide.rear
    inside = lead - math.copysign(1.0, horizon) * points[:, 0]  # behind the leading edge
    beside = wide.half_width - np.abs(points[:, 1])
    met = (beside > np.maximum(inside, 0.0)) & (2.0 * inside < wide.front - wide.rear)
    return max(0.0, float(-inside[met].max(initial=-abs(horizon))))


def free_slide(points: Floats, body: Footprint, direction: float, horizon: float) -> float:
    """Return how far the base can slide in a direction (rad, left positive), up to a horizon, m."""
    near = _within(points, body.turning_radius + horizon)
    if not len(near):
        return horizon
    along = np.linspace(0.0, horizon, max(1, math.ceil(horizon / _STEP_M)) + 1)
    x, y = along * math.cos(direction), along * math.sin(direction)
    return _first_touch(near, body, x, y, np.zeros_like(along), horizon)


def free_angle(points: Floats, body: Footprint, horizon: float) -> float:
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


def _within(points: Floats, reach: float) -> Floats:
    return points[points[:, 0] ** 2 + points[:, 1] ** 2 < reach * reach]


def _first_touch(
    points: Floats, body: Footprint, x: Floats, y: Floats, yaw: Floats, horizon: float
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
