"""Poses of navigation goals on the map of a world, by the planner of the servers."""

from __future__ import annotations

import math

from action_servers.core.grid import survey
from action_servers.core.maneuver import Grid
from action_servers.navigation.path import cost_model
from action_servers.navigation.planner import NoPath, departures, goal_nodes, road_map
from bt_mission.robots.model import RobotModel
from sim.world.occupancy import rasterise
from sim.world.world import World


class PoseChecker:
    """Reports places of a world where the planner finds no space for a robot.

    Only fixed obstacles count: moving ones are not on the map.
    """

    def __init__(self, world: World, robot: RobotModel) -> None:
        self._world = world
        drawn = rasterise(world)
        grid = Grid(drawn.resolution, *drawn.origin, drawn.cells)
        self._roads = road_map(survey(grid), cost_model(robot.passing_radius))

    def why_unreachable(self, x: float, y: float) -> str | None:
        """Return why no robot can reach a point of the map, in metres, or None."""
        nearest = goal_nodes(self._roads, (x, y))
        return (
            f"{nearest.reason}, in the world '{self._world.name}'"
            if isinstance(nearest, NoPath)
            else None
        )

    def reaches(self, start: tuple[float, float], goal: tuple[float, float]) -> bool:
        """Return whether a path leads from one point of the map to another, m."""
        starts, nearest = departures(self._roads, start), goal_nodes(self._roads, goal)
        if isinstance(nearest, NoPath) or not starts:
            return False
        price, _ = self._roads.prices_to(starts[0])
        return math.isfinite(price[nearest[0]])
