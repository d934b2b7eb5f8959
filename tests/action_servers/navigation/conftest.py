"""Worlds written by hand, and a tiny robot with a lidar that moves in them.

A character is 0.2 m: `#` a wall on the map, `o` an obstacle that the map does not have, `?` a place
that the map does not know, `R` the robot (facing right), `G` the goal, anything else free. The
corner of the lower left character is the origin.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from action_servers.core.governor import Governor
from action_servers.core.maneuver import ZERO, Finished, Grid, Maneuver, Observation, Scan
from bt_mission.core.geometry import Pose2D, Twist2D
from bt_mission.core.robot.model import RobotModel, load_robot

CHARACTER_M = 0.2
CELLS = 4
RAYS = 180
RAY_STEP_M = 0.02
STEP_S = 0.05
SUBSTEPS = 5


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


@dataclass
class TinyRobot:
    """A base without mass that follows its twist within the limits, and a lidar without noise."""

    model: RobotModel
    world: World
    pose: Pose2D
    twist: Twist2D = ZERO
    time_s: float = 10.0
    stuck: bool = False
    pose_lost: bool = False
    scan_lost: bool = False
    collided: bool = False
    travelled: float = 0.0
    reversed_m: float = 0.0
    seen: Observation = field(default_factory=lambda: Observation(0.0))
    finished: Finished | None = None
    trace: list[tuple[float, Pose2D, Twist2D]] = field(default_factory=list)

    def observe(self) -> Observation:
        seen = replace(self.seen, time_s=self.time_s, velocity=self.twist, grid=self.world.grid)
        if not self.pose_lost:
            seen = replace(seen, odom=self.pose, odom_stamp_s=self.time_s, map_pose=self.pose)
        if not self.scan_lost and round(self.time_s / STEP_S) % 2 == 0:
            seen = replace(seen, scan=self.scan())
        self.seen = seen
        return seen

    def scan(self) -> Scan:
        lidar, pose = self.model.lidar, self.pose
        x = pose.x + lidar.x * math.cos(pose.yaw)
        y = pose.y + lidar.x * math.sin(pose.yaw)
        angles = pose.yaw + np.arange(RAYS) * math.tau / RAYS
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

    def move(self, wanted: Twist2D) -> None:
        seconds = STEP_S / SUBSTEPS
        for _ in range(SUBSTEPS):
            linear = _toward(
                self.twist.linear, wanted.linear, self.model.max_linear_acceleration * seconds
            )
            angular = _toward(
                self.twist.angular, wanted.angular, self.model.max_angular_acceleration * seconds
            )
            self.twist = Twist2D(linear, angular)
            if not self.stuck:
                yaw = self.pose.yaw + angular * seconds / 2
                step = linear * seconds
                self.travelled += abs(step)
                self.reversed_m += max(0.0, -step)
                self.pose = Pose2D(
                    self.pose.x + step * math.cos(yaw),
                    self.pose.y + step * math.sin(yaw),
                    math.remainder(self.pose.yaw + angular * seconds, math.tau),
                )
        self.collided = self.collided or self._touches()
        self.time_s = round(self.time_s + STEP_S, 9)

    def _touches(self) -> bool:
        hull = self.model.hull
        body_half = self.model.body.size[1] / 2
        along = np.linspace(hull.rear, hull.front, 12)
        side = np.full_like(along, body_half)
        wheel = np.array([self.model.drive.wheel_radius, -self.model.drive.wheel_radius])
        x = np.concatenate(
            (along, along, np.full(6, hull.rear), np.full(6, hull.front), wheel, wheel)
        )
        edge = np.linspace(-body_half, body_half, 6)
        reach = np.full(2, hull.half_width)
        y = np.concatenate((side, -side, edge, edge, reach, -reach))
        cosine, sine = math.cos(self.pose.yaw), math.sin(self.pose.yaw)
        solid = self.world.is_solid(
            self.pose.x + cosine * x - sine * y, self.pose.y + sine * x + cosine * y
        )
        return bool(solid.any())

    def run(
        self,
        maneuver: Maneuver,
        limit_s: float = 120.0,
        each: Callable[["TinyRobot"], None] = lambda robot: None,
    ) -> Finished | None:
        """Step a maneuver until it ends; None when it has not by `limit_s`."""
        governor = Governor(self.model)
        start_s = self.time_s
        while self.time_s - start_s < limit_s:
            each(self)
            now = governor.look(self.observe())
            answer = maneuver.step(now)
            if isinstance(answer, Finished):
                self.finished = answer
                return answer
            twist = governor.allow(answer, now).twist
            self.trace.append((self.time_s, self.pose, twist))
            self.move(twist)
        return None

    def distance_to(self, pose: Pose2D) -> float:
        return math.hypot(pose.x - self.pose.x, pose.y - self.pose.y)


def _toward(value: float, wanted: float, step: float) -> float:
    return value + min(step, max(-step, wanted - value))


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
