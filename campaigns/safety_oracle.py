"""Whether a robot that knew how everything moves could have kept out of a contact.

All of it is ground truth. Arcs of constant curvature, and standing, are tried from where the robot
was up to three seconds before the contact, within its limits; one that touches nothing until a
second after it would have been a way out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from bt_mission.robots.model import RobotModel
from sim.world.shapes import Obstacle

Floats = npt.NDArray[np.float64]

LEADS_S = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0)
AFTER_S = 1.0
STEP_S = 0.05
SHARES = (-1.0, -0.5, 0.0, 0.5, 1.0)
SPACING_M = 0.03
LOOK_M = 0.02


@dataclass(frozen=True)
class State:
    """The robot at a time (s since the world began): pose (m, rad), m/s and rad/s."""

    time_s: float
    pose: tuple[float, float, float]
    velocity: tuple[float, float]


class Oracle:
    """Looks back from contacts in one world."""

    def __init__(self, robot: RobotModel, obstacles: Sequence[Obstacle]) -> None:
        self._robot = robot
        self._obstacles = obstacles
        self._outline = _outline(robot)

    def way_out(self, states: Sequence[State], contact_s: float) -> tuple[bool, bool]:
        """Return whether any arc, and whether standing still, would have avoided a contact."""
        arcs = np.array([(along, turned) for along in SHARES for turned in SHARES])
        standing = (arcs == 0.0).all(axis=1)
        moved = stood = False
        for lead_s in LEADS_S:
            then = [state for state in states if state.time_s <= contact_s - lead_s]
            if not then:
                break
            free = self._free(then[-1], arcs, contact_s - then[-1].time_s)
            moved, stood = moved or bool(free.any()), stood or bool(free[standing].any())
        return moved, stood

    def is_seen(self, state: State, mover: Obstacle) -> bool:
        """Whether the lidar, which looks all round, has a line of sight to what moves."""
        lidar = self._robot.lidar
        x, y, yaw = state.pose
        x += lidar.x * math.cos(yaw)
        y += lidar.x * math.sin(yaw)
        placed = _placed(mover, state.time_s)
        far = math.dist((x, y), (placed.x, placed.y)) - placed.radius
        if not lidar.min_range <= far <= lidar.max_range:
            return far < lidar.min_range
        share = np.arange(0.0, 1.0, LOOK_M / far) * far / (far + placed.radius)
        points = np.stack([x + share * (placed.x - x), y + share * (placed.y - y)])
        others = (
            _placed(obstacle, state.time_s)
            for obstacle in self._obstacles
            if obstacle.name != mover.name
        )
        return all((_gap(other, *points) > 0.0).all() for other in others)

    def _free(self, state: State, arcs: Floats, lead_s: float) -> npt.NDArray[np.bool_]:
        """Whether each arc, driven until half a second after the contact, touches nothing."""
        times = np.arange(0.0, lead_s + AFTER_S, STEP_S)
        x, y, yaw = self._poses(state, arcs, times, lead_s + AFTER_S / 2)
        cosine, sine = np.cos(yaw)[..., None], np.sin(yaw)[..., None]
        ahead, left = self._outline
        outline = (
            x[..., None] + cosine * ahead - sine * left,
            y[..., None] + sine * ahead + cosine * left,
        )
        free = np.ones(len(arcs), dtype=bool)
        for obstacle in self._obstacles:
            if obstacle.motion is None:
                free &= (_gap(obstacle, *outline) > 0.0).all(axis=(1, 2))
                continue
            for index, after_s in enumerate(times):
                at = _placed(obstacle, state.time_s + after_s)
                free &= (_gap(at, outline[0][:, index], outline[1][:, index]) > 0.0).all(axis=1)
        return free

    def _poses(
        self, state: State, arcs: Floats, times: Floats, drive_s: float
    ) -> tuple[Floats, Floats, Floats]:
        robot = self._robot
        wanted = arcs * (robot.max_linear_velocity, robot.max_angular_velocity)
        most = STEP_S * np.array([robot.max_linear_acceleration, robot.max_angular_acceleration])
        velocity = np.tile(state.velocity, (len(arcs), 1))
        poses = np.empty((3, len(arcs), len(times)))
        poses[:, :, 0] = np.array(state.pose)[:, None]
        for index in range(1, len(times)):
            to = wanted if times[index] <= drive_s else 0.0 * wanted
            velocity = velocity + np.clip(to - velocity, -most, most)
            x, y, yaw = poses[:, :, index - 1]
            middle = yaw + velocity[:, 1] * STEP_S / 2
            poses[0, :, index] = x + velocity[:, 0] * np.cos(middle) * STEP_S
            poses[1, :, index] = y + velocity[:, 0] * np.sin(middle) * STEP_S
            poses[2, :, index] = yaw + velocity[:, 1] * STEP_S
        return poses[0], poses[1], poses[2]


def _outline(robot: RobotModel) -> tuple[Floats, Floats]:
    """Return points round the hull, m ahead and to the left."""
    hull = robot.hull
    corners = [
        (hull.front, hull.half_width),
        (hull.rear, hull.half_width),
        (hull.rear, -hull.half_width),
        (hull.front, -hull.half_width),
    ]
    points: list[Floats] = []
    for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
        count = math.ceil(math.dist(start, end) / SPACING_M)
        points.append(np.linspace(start, end, count, endpoint=False))
    ahead, left = np.vstack(points).T
    # Its corners behind the wheels are cut off by the circle that it turns in.
    inside = np.hypot(ahead, left) <= robot.turning_radius
    return ahead[inside], left[inside]


def _placed(obstacle: Obstacle, time_s: float) -> Obstacle:
    if obstacle.motion is None:
        return obstacle
    x, y, *_ = obstacle.motion.at(time_s)
    return replace(obstacle, x=x, y=y)


def _gap(obstacle: Obstacle, x: Floats, y: Floats) -> Floats:
    """Return how far points are from an obstacle, m; 0 or less inside."""
    across, along = x - obstacle.x, y - obstacle.y
    if obstacle.kind == "cylinder":
        return np.hypot(across, along) - obstacle.radius
    cosine, sine = math.cos(obstacle.yaw), math.sin(obstacle.yaw)
    return np.maximum(
        np.abs(cosine * across + sine * along) - obstacle.size[0] / 2,
        np.abs(cosine * along - sine * across) - obstacle.size[1] / 2,
    )
