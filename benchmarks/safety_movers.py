"""Explorations among obstacles that move, and what the robot did when one of them met it."""

from __future__ import annotations

import math
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bt_mission_interfaces.msg import Collision

from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage

WORLDS = ("dqn_stage3", "dqn_stage4")
"""Both have two cylinders that go to and fro at 0.1 m/s."""

MISSION = "missions/explore_informed.yaml"
DURATION_S = 180
SPEED = 0.26
DRIVES, TURNS = 0.01, 0.02
"""m/s and rad/s commanded, from which the base drives or turns."""

FRONT_M = 0.02
"""Depth of what counts as the hull's front, m."""


@dataclass(frozen=True)
class Outing:
    """One exploration: how far it went, and its collisions by what the base did, and with what.

    What it did is "driving into", where the contact is on the hull's front, "driving", "turning" or
    "standing"; with what, "mover" or "fixed".
    """

    world: str
    driven_m: float
    collisions: Counter[tuple[str, str]]


def outing(world: str, seed: int, seconds: int = DURATION_S) -> Outing:
    """Explore for three virtual minutes."""
    given = {"duration": seconds, "speed": SPEED}
    mission = load(MISSION, set=given, seed=seed, world=world)
    met: Counter[tuple[str, str]] = Counter()
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(mission, image_folder=Path(folder), say=lambda _: None) as stage,
    ):
        movers = {one.name for one in stage.sim.physics.world.moving}
        heard: list[Collision] = []
        stage.node.create_subscription(Collision, "collisions", heard.append, 10)
        front = stage.sim.simulation.robot.hull.front - FRONT_M
        while not stage.is_done:
            linear, angular = stage.sim.simulation.commanded
            stage.step()
            for collision in heard:
                doing = "turning" if abs(angular) > TURNS else "standing"
                if abs(linear) > DRIVES:
                    ahead = _ahead(stage.sim.simulation.pose, collision.point)
                    doing = "driving into" if linear > 0 and ahead > front else "driving"
                met[doing, "mover" if collision.obstacle in movers else "fixed"] += 1
            heard.clear()
        return Outing(world, stage.distance_travelled_m, met)


def _ahead(pose: tuple[float, float, float], point: Any) -> float:
    """How far ahead of the axle a point of the map lies, m."""
    x, y, yaw = pose
    return (point.x - x) * math.cos(yaw) + (point.y - y) * math.sin(yaw)
