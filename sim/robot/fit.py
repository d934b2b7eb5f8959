"""Whether a robot fits at a place, and the error if it does not.

Geometry alone, without MuJoCo: `check` asks here first.
"""

from __future__ import annotations

import math
from collections.abc import Collection

from bt_mission.base.errors import BtMissionError
from bt_mission.robots.body import PolygonBody
from sim.physics.spawn import RobotSpawn
from sim.world.world import Spawn, World

TOUCHING = 1e-4
"""Metres by which a robot that is put somewhere may be in what it touches."""


class SpawnError(BtMissionError):
    """The robot does not fit at its start, or at a new place.

    Args:
        robot: Its name; empty for a robot alone.
    """

    code = "BT-803"

    def __init__(self, message: str, robot: str = "") -> None:
        super().__init__(message)
        self.robot = robot


def off_floor(world: World, entrant: RobotSpawn, spawn: Spawn) -> SpawnError | None:
    """Return the error if a robot starts beside the floor of its world, or None."""
    length, width = world.size
    if world.has_floor_at(spawn.x, spawn.y):
        cos, sin = math.cos(math.radians(spawn.yaw)), math.sin(math.radians(spawn.yaw))
        wheels = entrant.robot.drive.places
        stands = all(
            world.has_floor_at(spawn.x + x * cos - y * sin, spawn.y + x * sin + y * cos)
            for x, y in wheels
        )
        if stands:
            return None
        return SpawnError(
            f"a wheel of the {entrant.robot.name} at ({spawn.x:g}, {spawn.y:g},"
            f" {spawn.yaw:g} deg) is beside {world.floor}; make the floor larger, or move the"
            " spawn",
            entrant.name,
        )
    return SpawnError(
        f"({spawn.x:g}, {spawn.y:g}) is outside the world '{world.name}', which is"
        f" {length:g} m by {width:g} m around (0, 0)",
        entrant.name,
    )


def is_clear(world: World, entrant: RobotSpawn, spawn: Spawn) -> bool:
    """Return whether nothing is near enough to touch a robot at its start, however it is turned.

    False decides nothing. So it is for a body that only MuJoCo knows: a model, or a mesh.
    """
    robot = entrant.robot
    if robot.model is not None or isinstance(robot.body, PolygonBody):
        return False
    reach = robot.turning_radius + TOUCHING
    return all(obstacle.distance(spawn.x, spawn.y) > reach for obstacle in world.obstacles)


def no_room_at_start(
    world: World, entrant: RobotSpawn, spawn: Spawn, touched: Collection[str]
) -> SpawnError:
    """Return the error of a robot that touches obstacles at its start."""
    names = ", ".join(sorted(f"'{obstacle}'" for obstacle in touched))
    who = f"a {entrant.robot.name}" + (f" ({entrant.name})" if entrant.name else "")
    return SpawnError(
        f"world {world.name}: {who} does not fit at the spawn"
        f" ({spawn.x:g}, {spawn.y:g}, {spawn.yaw:g} deg): it touches {names};"
        " move the spawn, or make room",
        entrant.name,
    )


def no_room(model: str, pose: tuple[float, float, float], obstacle: str | None) -> SpawnError:
    """Return the error of a robot that would be in an obstacle at a pose (m, rad)."""
    x, y, yaw = pose
    return SpawnError(
        f"a {model} does not fit at ({x:g}, {y:g}, {math.degrees(yaw):g} deg):"
        f" it would be in '{obstacle}'"
    )
