"""The free places of a world that the robot can reach from its start."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy import ndimage

from bt_mission.base.files import find
from bt_mission.base.yaml.document import read
from bt_mission.commands.falsify.candidate import given_world
from bt_mission.robots.model import load_robot
from bt_mission.scenarios.concrete.base_scenario import BaseScenario
from bt_mission.scenarios.concrete.ranges import ValueRange
from sim.world.loader import load_world, world_in
from sim.world.occupancy import FREE, OccupancyMap, rasterise
from sim.world.world import World

ROOM = 0.05
"""Metres around the circle that the robot sweeps when it turns."""


class FreeSpace:
    """Free places of the worlds of a search; a map is made at its first use.

    Args:
        base: The scenario that is varied.
    """

    def __init__(self, base: BaseScenario) -> None:
        self._base = base
        self._maps: dict[str | None, OccupancyMap] = {}

    def floor(self, world: str | None) -> tuple[ValueRange, ValueRange]:
        """Return the ends of x and y of a world, m; None is that of the base."""
        grid = self._map(world)
        rows, columns = grid.cells.shape
        (x, y), edge = grid.origin, grid.resolution
        return ValueRange(_r(x), _r(x + columns * edge)), ValueRange(_r(y), _r(y + rows * edge))

    def nearest(self, world: str | None, x: float, y: float) -> tuple[float, float]:
        """Return the nearest free place, m; the place itself if it is free."""
        grid = self._map(world)
        edge, (left, low) = grid.resolution, grid.origin
        rows, columns = grid.cells.shape
        row = min(max(int((y - low) / edge), 0), rows - 1)
        column = min(max(int((x - left) / edge), 0), columns - 1)
        if grid.cells[row, column] == FREE:
            return x, y
        free = np.argwhere(grid.cells == FREE)
        near = free[np.argmin(((free - (row, column)) ** 2).sum(axis=1))]
        return _r(left + (near[1] + 0.5) * edge), _r(low + (near[0] + 0.5) * edge)

    def _map(self, world: str | None) -> OccupancyMap:
        if world not in self._maps:
            self._maps[world] = self._made(world)
        return self._maps[world]

    def _made(self, name: str | None) -> OccupancyMap:
        mission = self._base.mission
        world = self._world(name)
        robot = load_robot(find("robots", mission.robot, near=mission.file))
        plan = rasterise(world)
        reach = (robot.turning_radius + ROOM) / plan.resolution
        distance: Any = ndimage.distance_transform_edt(
            np.pad(plan.cells, 1, constant_values=1) == FREE
        )
        has_room = distance[1:-1, 1:-1] > reach
        areas, _ = ndimage.label(has_room)
        row = math.floor((world.spawn.y - plan.origin[1]) / plan.resolution)
        column = math.floor((world.spawn.x - plan.origin[0]) / plan.resolution)
        area = areas[row, column] or 1
        cells = np.where(areas == area, FREE, 1).astype(plan.cells.dtype)
        cells[row, column] = FREE  # the world's own place counts, however little room it has
        return OccupancyMap(plan.resolution, plan.origin, cells)

    def _world(self, name: str | None) -> World:
        base = self._base
        given = base.data.get("world")
        if name is None and isinstance(given, dict):
            return world_in(read(base.path), ("world",))
        if name is None:
            name = given_world(base, given) if isinstance(given, str) else base.mission.world
        return load_world(find("worlds", str(name), near=base.mission.file))


def _r(value: float) -> float:
    return round(float(value), 3)
