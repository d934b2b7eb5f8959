"""Where arcs take the hull, and when it meets what moves: many arcs at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from action_servers.core.clearance import Points
from action_servers.core.drive_limits import DriveLimits
from action_servers.core.footprint import Footprint
from action_servers.core.grid import Floats
from bt_mission.base.geometry import Twist2D

STEP_S = 0.1
"""The time between two places on an arc."""


@dataclass(frozen=True, slots=True)
class MovingPoints:
    """Moving points from the base, `n x 2` m, with velocity, m/s, and turn rate, rad/s."""

    points: Points
    rates: Points
    turning: Floats

    def at(self, times: Floats) -> Floats:
        """Return the points at times from now, `times x n x 2`."""
        turned = times[:, None] * self.turning
        along = times[:, None] * np.sinc(turned / math.pi)
        aside = times[:, None] * np.sinc(turned / math.tau) * np.sin(turned / 2)
        left = np.stack([-self.rates[:, 1], self.rates[:, 0]], axis=1)
        return self.points + along[:, :, None] * self.rates + aside[:, :, None] * left


def rolled_out(
    velocity: Twist2D, arcs: Sequence[Twist2D], times: Floats, for_s: float, limits: DriveLimits
) -> Floats:
    """Return x, y and yaw of each arc at each time, `arcs x times x 3`, from the base.

    It begins at a velocity; arcs are driven for a time, s, and then the base brakes. `times` are
    `STEP_S` apart.
    """
    linear = np.full(len(arcs), velocity.linear)
    angular = np.full(len(arcs), velocity.angular)
    lateral = np.full(len(arcs), velocity.lateral)
    wanted = np.array([(arc.linear, arc.angular, arc.lateral) for arc in arcs])
    slides = velocity.lateral != 0.0 or bool(wanted[:, 2].any())
    poses = np.zeros((len(arcs), len(times), 3))
    step = limits.acceleration * STEP_S, limits.angular_acceleration * STEP_S
    for index in range(1, len(times)):
        to = wanted if times[index] <= for_s + STEP_S / 2 else np.zeros_like(wanted)
        linear = linear + np.clip(to[:, 0] - linear, -step[0], step[0])
        angular = angular + np.clip(to[:, 1] - angular, -step[1], step[1])
        x, y, yaw = poses[:, index - 1].T
        middle = yaw + 0.5 * angular * STEP_S
        poses[:, index, 0] = x + linear * np.cos(middle) * STEP_S
        poses[:, index, 1] = y + linear * np.sin(middle) * STEP_S
        poses[:, index, 2] = yaw + angular * STEP_S
        if slides:
            lateral = lateral + np.clip(to[:, 2] - lateral, -step[0], step[0])
            poses[:, index, 0] -= lateral * np.sin(middle) * STEP_S
            poses[:, index, 1] += lateral * np.cos(middle) * STEP_S
    return poses


def grown(body: Footprint, margin: float) -> Footprint:
    """Return a footprint that is larger by a margin in metres, its circle too."""
    return replace(body.grown(margin), turning_radius=body.turning_radius + margin)


def depth_in(body: Footprint, poses: Floats, points: Floats) -> Floats:
    """Return how deep points lie in the hull, m: `arcs x times x points`.

    `points` are `times x points x 2`, or `1 x points x 2` for those that stay.
    """
    yaw = poses[:, :, 2, None]
    cosine, sine = np.cos(yaw), np.sin(yaw)
    across = points[None, :, :, 0] - poses[:, :, 0, None]
    along = points[None, :, :, 1] - poses[:, :, 1, None]
    return body.depth(cosine * across + sine * along, cosine * along - sine * across)
