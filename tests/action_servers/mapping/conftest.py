"""A kinematic robot that maps walls as it drives."""

import dataclasses
import math
from collections.abc import Iterable
from typing import Any

import pytest

from action_servers.core.maneuver import Finished, Grid, Maneuver, Observation
from action_servers.mapping.occupancy import OccupancyMapper
from bt_mission.core.geometry import Pose2D

SCAN_EVERY_S = 0.2
MAP_EVERY_S = 1.0


def box(x: float, y: float, width: float, height: float) -> list[tuple[float, float, float, float]]:
    """Four walls around a rectangle whose lower left corner is at x, y; metres."""
    right, top = x + width, y + height
    return [(x, y, right, y), (right, y, right, top), (right, top, x, top), (x, top, x, y)]


class MappingRobot:
    """A fake robot whose observations hold the map that it has made so far, renewed once a second.

    `maps=False` keeps the first map for ever.
    """

    def __init__(self, fake: Any, *, maps: bool = True) -> None:
        self.fake = fake
        self.mapper = OccupancyMapper(fake.robot.lidar)
        self.maps = maps
        self.grid: Grid | None = None
        self.closest = math.inf
        self._scan_s = self._map_s = -math.inf

    def observe(self) -> Observation:
        """What the robot's topics and the mapper's would tell now."""
        now: Observation = self.fake.observe()
        pose = Pose2D(self.fake.x, self.fake.y, self.fake.yaw)
        if now.scan is not None and now.time_s - self._scan_s > SCAN_EVERY_S - 1e-6:
            self._scan_s = now.time_s
            if now.scan.stamp_s == now.time_s:
                self.mapper.add(now.scan, pose)
            self.closest = min(self.closest, float(now.scan.ranges.min()))
        if now.time_s - self._map_s > MAP_EVERY_S - 1e-6 and (self.maps or self.grid is None):
            self._map_s = now.time_s
            self.grid = self.mapper.grid(now.time_s)
        return dataclasses.replace(now, map_pose=pose, grid=self.grid)

    def run(self, maneuver: Maneuver, limit_s: float = 300.0) -> Finished:
        """Step a maneuver at 20 Hz until it ends."""
        for _ in range(round(limit_s * 20)):
            answer = maneuver.step(self.observe())
            if isinstance(answer, Finished):
                return answer
            self.fake.move(answer)
        raise AssertionError(f"the maneuver has not ended within {limit_s} s")


@pytest.fixture
def walls_of():
    """Make walls around a rectangle: `walls_of(x, y, width, height)`."""
    return box


@pytest.fixture
def mapping_robot(fake, waffle):
    """Put a Waffle that maps among walls, at the origin."""

    def make(walls: Iterable[tuple[float, float, float, float]], **options: Any) -> MappingRobot:
        return MappingRobot(fake(waffle, walls), **options)

    return make
