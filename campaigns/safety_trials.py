"""The trials of `campaigns/safety.py` that run on the virtual clock, each with a true figure.

Seeded: the same seed gives the same poses, the same noise and the same figures.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from bt_mission_interfaces.action import ExploreForward
from safety_rig import Rig

from sim.world.shapes import Obstacle

WORLDS = ("explore_arena", "nav_arena", "turtlebot3_world")
SPEEDS = (0.1, 0.2, 0.26)
STOPPING_DISTANCE = 0.3
INTRUDER_GAP = 0.4
"""Metres: how far ahead of the hull an obstacle appears."""

NEAREST, FARTHEST = 0.6, 1.5
"""Metres between hull and obstacle at the start of a drive: enough to reach full speed."""

OBLIQUE = math.radians(60)
"""The farthest from square at which a wall is driven at."""

SETTLE_S = 2.0
"""Seconds at a new place until a drive begins. Sooner, scans of the last place, up to 1.6 s old,
are compared with those of the new one: walls seem to move, and the base gives way to them."""

LIMIT_S = 60.0

DRIVES_A_RIG = 25
"""Drives after which world and servers are made anew: well before rclpy forgets results, which it
does 900 s after a goal."""


@dataclass(frozen=True)
class Pose:
    """Where a drive begins, m and rad, and what it aims at."""

    x: float
    y: float
    yaw: float
    target: str


@dataclass(frozen=True)
class Drive:
    """How one drive ended, by the truth of the simulation."""

    world: str
    speed: float
    target: str
    status: str
    reason: str
    collisions: int
    surplus: float
    """Metres of distance left beyond the stopping distance; below 0, it came nearer."""


def poses(rig: Rig, count: int, seed: int) -> list[Pose]:
    """Return seeded poses that aim at every obstacle of the world in turn, at any angle."""
    rng = random.Random(seed)
    drawn: list[Pose] = []
    obstacles = rig.world.obstacles
    turn = 0
    while len(drawn) < count:
        target = obstacles[turn % len(obstacles)]
        turn += 1
        for _ in range(200):
            pose = _aimed(target, rig, rng)
            if rig.place(pose.x, pose.y, pose.yaw) and _in_reach(rig):
                drawn.append(pose)
                break
    return drawn


def _in_reach(rig: Rig) -> bool:
    x, y, _ = rig.sim.robots[0].pose
    width, height = rig.world.size
    inside = abs(x) < width / 2 and abs(y) < height / 2
    return inside and NEAREST - 0.1 <= rig.gap_ahead() <= FARTHEST + 0.5


def _aimed(target: Obstacle, rig: Rig, rng: random.Random) -> Pose:
    x, y, normal = _on_surface(target, rng)
    yaw = normal + math.pi + rng.uniform(-OBLIQUE, OBLIQUE)
    away = rng.uniform(NEAREST, FARTHEST) + rig.robot.hull.front
    return Pose(x - away * math.cos(yaw), y - away * math.sin(yaw), yaw, target.name)


def _on_surface(target: Obstacle, rng: random.Random) -> tuple[float, float, float]:
    """Return a random point on an obstacle's outline, and the direction that leads away there."""
    if target.kind == "cylinder":
        normal = rng.uniform(-math.pi, math.pi)
        radius = target.radius
        return target.x + radius * math.cos(normal), target.y + radius * math.sin(normal), normal
    length, thickness, _ = target.size
    side = rng.choices(range(4), weights=[length, thickness, length, thickness])[0]
    along = rng.uniform(-0.5, 0.5) * (length if side % 2 == 0 else thickness)
    out = (thickness if side % 2 == 0 else length) / 2
    normal = target.yaw + (math.pi / 2, math.pi, -math.pi / 2, 0.0)[side]
    across = normal - math.pi / 2
    return (
        target.x + out * math.cos(normal) + along * math.cos(across),
        target.y + out * math.sin(normal) + along * math.sin(across),
        normal,
    )


def drives(
    world: str, *, count: int, speeds: tuple[float, ...] = SPEEDS, seed: int = 1, appears: bool
) -> Iterator[Drive]:
    """Drive from each pose at each speed; where one `appears`, at an obstacle on the way, too."""
    with Rig(world) as rig:
        starts = poses(rig, count, seed)
    todo = [(pose, speed) for speed in speeds for pose in starts]
    for begin in range(0, len(todo), DRIVES_A_RIG):
        noise = seed + begin + sum(world.encode())  # another in each world and rig
        with Rig(world, seed=noise, intruder=True) as rig:
            rig.prepare("explore_forward", ExploreForward)
            rig.wait(SETTLE_S)
            for pose, speed in todo[begin : begin + DRIVES_A_RIG]:
                yield _drive(rig, pose, speed, appears=appears)


def _drive(rig: Rig, pose: Pose, speed: float, *, appears: bool) -> Drive:
    rig.place(pose.x, pose.y, pose.yaw)
    rig.wait(SETTLE_S)
    before = rig.collisions
    goal = ExploreForward.Goal(fwd_velocity=speed, stopping_distance=STOPPING_DISTANCE)
    sent = rig.send("explore_forward", goal)
    if appears:
        # At full speed, and at no particular phase of scan and control.
        rig.until(lambda: rig.sim.robots[0].velocity[0] > 0.98 * speed, 2.0)
        rig.wait(0.005 * (hash(pose.x) % 20))
        rig.intrude(INTRUDER_GAP)
    rig.until(lambda: bool(sent.status) or sent.accepted is False, LIMIT_S)
    rig.until(lambda: rig.stands, 1.0)
    return Drive(
        rig.world.name,
        speed,
        pose.target,
        sent.status or "refused",
        sent.result.error_msg if sent.result else "",
        rig.collisions - before,
        rig.gap_ahead() - STOPPING_DISTANCE,
    )


@dataclass(frozen=True)
class Stop:
    """How a running goal ended after something happened, by the truth of the simulation."""

    action: str
    stood_after_s: float
    status: str
    reason: str


def stopped(rig: Rig, name: str, goal: Any, happening: Any, *, limit_s: float = 3.0) -> Stop:
    """Run a goal until the base moves, let something happen; tells when the base then stood."""
    sent = rig.send(name, goal)
    if not rig.until(lambda: not rig.stands, 5.0):
        return Stop(name, math.nan, sent.status or "it never moved", "")
    rig.wait(0.3)
    rig.look_closely()
    start_s = rig.now_s
    happening(rig)
    rig.until(lambda: rig.stands, limit_s)
    after_s = rig.now_s - start_s if rig.stands else math.inf
    rig.until(lambda: bool(sent.status), limit_s)
    return Stop(name, after_s, sent.status, sent.result.error_msg if sent.result else "")
