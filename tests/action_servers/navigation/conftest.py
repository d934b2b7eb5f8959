"""Worlds written by hand, and a tiny robot with a lidar that moves in them.

A character is 0.2 m: `#` a wall on the map, `o` an obstacle that the map does not have, `?` a place
that the map does not know, `R` the robot (facing right), `G` the goal, anything else free. The
corner of the lower left character is the origin.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from action_servers.core.maneuver import Finished, Grid, Maneuver, Observation, Scan
from bt_mission.base.geometry import Pose2D, Twist2D
from bt_mission.robots.model import RobotModel, load_robot
from tests.support.fake_robot import FakeRobot

CHARACTER_M = 0.2
CELLS = 4
RAYS = 180
RAY_STEP_M = 0.02


@dataclass
class World:
    """The true world, the map of it, and where the robot and its goal are."""

    grid: Grid
    solid: npt.NDArray[np.bool_]
    start: Pose2D
    goal: Pose2D

    def set_solid(self, x: float, y: float, half: float, *, solid: bool = True) -> None:
        """Put a square obstacle of half an edge `half` there, or take it away."""
        rows, columns = self.solid.shape
        low_x, high_x, low_y, high_y = (
            round(value / self.grid.resolution)
            for value in (x - half, x + half, y - half, y + half)
        )
        self.solid[max(0, low_y) : min(rows, high_y), max(0, low_x) : min(columns, high_x)] = solid

    def is_solid(self, x: Any, y: Any) -> Any:
        columns = np.clip(
            np.floor(x / self.grid.resolution).astype(int), 0, self.solid.shape[1] - 1
        )
        rows = np.clip(np.floor(y / self.grid.resolution).astype(int), 0, self.solid.shape[0] - 1)
        return self.solid[rows, columns]


def read_world(text: str) -> World:
    """Read a world; see the module."""
    lines = [line.strip() for line in text.strip().splitlines()][::-1]
    assert len({len(line) for line in lines}) == 1, "lines of different length"
    characters = np.array([list(line) for line in lines])
    big = np.kron(np.arange(characters.size).reshape(characters.shape), np.ones((CELLS, CELLS)))
    cells = characters.ravel()[big.astype(int)]
    occupancy = np.where(cells == "#", 100, np.where(cells == "?", -1, 0)).astype(np.int8)
    grid = Grid(CHARACTER_M / CELLS, 0.0, 0.0, occupancy)

    def place(letter: str) -> Pose2D:
        rows, columns = np.nonzero(characters == letter)
        if not len(rows):
            return Pose2D(math.nan, math.nan, 0.0)
        return Pose2D((columns[0] + 0.5) * CHARACTER_M, (rows[0] + 0.5) * CHARACTER_M, 0.0)

    return World(grid, (cells == "#") | (cells == "o"), place("R"), place("G"))


class TinyRobot(FakeRobot):
    """A fake robot in a world, with a coarse lidar of 180 rays; it knows the map and its place."""

    def __init__(self, model: RobotModel, world: World, pose: Pose2D) -> None:
        super().__init__(model)
        self.seen = Observation(0.0)
        self.world = world
        self.pose = pose
        self.pose_lost = self.scan_lost = self.collided = False
        self.travelled = self.reversed_m = 0.0
        self.finished: Finished | None = None
        self.trace: list[tuple[float, Pose2D, Twist2D]] = []

    @property
    def pose(self) -> Pose2D:
        """Where it is on the map, which is its odometry, too."""
        return Pose2D(self.x, self.y, math.remainder(self.yaw, math.tau))

    @pose.setter
    def pose(self, pose: Pose2D) -> None:
        self.x, self.y, self.yaw = pose.x, pose.y, pose.yaw

    def observe(self) -> Observation:
        now = super().observe()
        known: dict[str, Any] = {"map_pose": self.pose}
        known |= {"odom": now.odom, "odom_stamp_s": now.odom_stamp_s}
        if self.pose_lost:
            known = {name: getattr(self.seen, name) for name in known}
        scan = self.seen.scan if self.scan_lost else now.scan
        self.seen = replace(now, grid=self.world.grid, scan=scan, **known)
        return self.seen

    def _scanned(self) -> Scan:
        lidar = self.robot.lidar
        x, y = self.x + lidar.x * math.cos(self.yaw), self.y + lidar.x * math.sin(self.yaw)
        angles = self.yaw + np.arange(RAYS) * math.tau / RAYS
        reach = np.arange(lidar.min_range, lidar.max_range, RAY_STEP_M)
        solid = self.world.is_solid(
            x + reach * np.cos(angles)[:, None], y + reach * np.sin(angles)[:, None]
        )
        ranges = np.where(solid.any(axis=1), reach[np.argmax(solid, axis=1)], np.inf)
        return Scan(
            self.time_s,
            0.0,
            math.tau / RAYS,
            lidar.min_range,
            lidar.max_range,
            ranges.astype(np.float32),
        )

    def move(self, twist: Twist2D, duration_s: float = 0.05) -> None:
        before = self.pose
        super().move(twist, duration_s)
        step = math.copysign(self.distance_to(before), self.linear)
        self.travelled += abs(step)
        self.reversed_m += max(0.0, -step)
        self.collided = self.collided or self._touches()

    def _touches(self) -> bool:
        hull = self.robot.hull
        body_half = self.robot.body.size[1] / 2
        along = np.linspace(hull.rear, hull.front, 12)
        side = np.full_like(along, body_half)
        wheel = np.array([self.robot.drive.wheel_radius, -self.robot.drive.wheel_radius])
        x = np.concatenate(
            (along, along, np.full(6, hull.rear), np.full(6, hull.front), wheel, wheel)
        )
        edge = np.linspace(-body_half, body_half, 6)
        reach = np.full(2, hull.half_width)
        y = np.concatenate((side, -side, edge, edge, reach, -reach))
        cosine, sine = math.cos(self.yaw), math.sin(self.yaw)
        solid = self.world.is_solid(self.x + cosine * x - sine * y, self.y + sine * x + cosine * y)
        return bool(solid.any())

    def drive(
        self,
        maneuver: Maneuver,
        limit_s: float = 120.0,
        each: Callable[["TinyRobot"], None] = lambda robot: None,
    ) -> Finished | None:
        """Step a maneuver until it ends; None when it has not by `limit_s`."""
        self.governor.begin()
        start_s = self.time_s
        while self.time_s - start_s < limit_s and self.finished is None:
            each(self)
            time_s, pose = self.time_s, self.pose
            answer = self.step(maneuver.step)
            if isinstance(answer, Finished):
                self.finished = answer
            else:
                self.trace.append((time_s, pose, self.twists[-1]))
        return self.finished

    def distance_to(self, pose: Pose2D) -> float:
        return math.hypot(pose.x - self.x, pose.y - self.y)


@pytest.fixture(scope="session")
def waffle() -> RobotModel:
    """The robot of these tests."""
    return load_robot("waffle")


@pytest.fixture
def world() -> Callable[[str], World]:
    """Read a world from text."""
    return read_world


@pytest.fixture
def robot_in(waffle) -> Callable[..., TinyRobot]:
    """Put a Waffle into a world, at its start unless a pose is given."""

    def make(place: World, pose: Pose2D | None = None, model: RobotModel = waffle) -> TinyRobot:
        return TinyRobot(model, place, pose or place.start)

    return make
