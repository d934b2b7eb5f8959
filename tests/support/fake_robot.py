"""A tiny kinematic robot among walls, for maneuvers without ROS and without MuJoCo."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import numpy as np

from action_servers.core.governor import Governor
from action_servers.core.maneuver import ZERO, Finished, Image, Maneuver, Observation, Scan
from bt_mission.base.geometry import Pose2D, Twist2D
from bt_mission.robots.model import RobotModel

T = TypeVar("T")

Wall = tuple[float, float, float, float]
"""A straight wall from x, y to x, y, metres."""

PHYSICS_STEP_S = 0.005


class FakeRobot:
    """Moves as told, within its acceleration; sees walls exactly, every `scan_period_s`."""

    def __init__(self, robot: RobotModel, walls: Iterable[Wall] = ()) -> None:
        self.robot = robot
        self.walls = np.array(list(walls), dtype=float).reshape(-1, 4)
        self.time_s = 10.0
        self.x = self.y = self.yaw = 0.0
        self.linear = self.angular = self.lateral = 0.0
        self.stuck = False
        self.scan_period_s = 0.1
        self.sees_images = False
        self.twists: list[Twist2D] = []
        self.changes: dict[str, Any] = {}
        self.governor = Governor(robot)
        self._scan: Scan | None = None
        self._image: Image | None = None

    def observe(self) -> Observation:
        """What the robot's topics would tell now; `changes` replaces single fields."""
        age_s = math.inf if self._scan is None else self.time_s - self._scan.stamp_s
        if not 0.0 <= age_s <= self.scan_period_s - 0.001:
            self._scan = self._scanned()
            self._image = self._picture() if self.sees_images else None
        now = Observation(
            time_s=self.time_s,
            odom=Pose2D(self.x, self.y, math.remainder(self.yaw, math.tau)),
            odom_stamp_s=self.time_s,
            velocity=Twist2D(self.linear, self.angular, self.lateral),
            scan=self._scan,
            image=self._image,
        )
        return dataclasses.replace(now, **self.changes)

    def move(self, twist: Twist2D, duration_s: float = 0.05) -> None:
        """Follow a command for a while."""
        self.twists.append(twist)
        for _ in range(round(duration_s / PHYSICS_STEP_S)):
            self.time_s = round(self.time_s + PHYSICS_STEP_S, 6)
            if self.stuck:
                continue
            most = self.robot.max_linear_acceleration * PHYSICS_STEP_S
            self.linear += float(np.clip(twist.linear - self.linear, -most, most))
            self.lateral += float(np.clip(twist.lateral - self.lateral, -most, most))
            most = self.robot.max_angular_acceleration * PHYSICS_STEP_S
            self.angular += float(np.clip(twist.angular - self.angular, -most, most))
            self.yaw += self.angular * PHYSICS_STEP_S
            self.x += self.linear * math.cos(self.yaw) * PHYSICS_STEP_S
            self.y += self.linear * math.sin(self.yaw) * PHYSICS_STEP_S
            if self.lateral:
                self.x -= self.lateral * math.sin(self.yaw) * PHYSICS_STEP_S
                self.y += self.lateral * math.cos(self.yaw) * PHYSICS_STEP_S

    def step(self, step: Callable[[Observation], T]) -> T:
        """Make a control step, governed as by the pilot; return what the maneuver answers."""
        now = self.governor.look(self.observe())
        answer = step(now)
        if isinstance(answer, Twist2D):
            self.move(self.governor.allow(answer, now).twist)
        return answer

    def run(self, maneuver: Maneuver, limit_s: float = 60.0) -> Finished:
        """Step a maneuver at 20 Hz until it ends."""
        self.governor.begin()
        for _ in range(round(limit_s * 20)):
            answer = self.step(maneuver.step)
            if isinstance(answer, Finished):
                self.twists.append(ZERO)
                return answer
        raise AssertionError(f"the maneuver has not ended within {limit_s} s")

    def run_for(self, maneuver: Maneuver, duration_s: float) -> None:
        """Step a maneuver that does not end for a while."""
        for _ in range(round(duration_s * 20)):
            answer = self.step(maneuver.step)
            assert isinstance(answer, Twist2D), answer

    def _scanned(self) -> Scan:
        lidar = self.robot.lidar
        angles = self.yaw + np.arange(lidar.rays) * math.tau / lidar.rays
        x = self.x + lidar.x * math.cos(self.yaw)
        y = self.y + lidar.x * math.sin(self.yaw)
        ranges = cast_rays(x, y, angles, self.walls)
        ranges[(ranges < lidar.min_range) | (ranges > lidar.max_range)] = math.inf
        return Scan(
            stamp_s=self.time_s,
            angle_min=0.0,
            angle_increment=math.tau / lidar.rays,
            range_min=lidar.min_range,
            range_max=lidar.max_range,
            ranges=ranges.astype(np.float32),
        )

    def _picture(self) -> Image:
        return Image(self.time_s, 2, 3, np.zeros((2, 3, 3), dtype=np.uint8))


def in_the_open(time_s: float, **changes: Any) -> Observation:
    """Return what a robot in the open knows at a time: fresh, and nothing in sight."""
    scan = Scan(time_s, 0.0, math.tau / 4, 0.12, 3.5, np.full(4, math.inf, dtype=np.float32))
    now = Observation(time_s, odom=Pose2D(0.0, 0.0, 0.0), odom_stamp_s=time_s, scan=scan)
    return dataclasses.replace(now, **changes)


def cast_rays(x: float, y: float, angles: np.ndarray, walls: np.ndarray) -> np.ndarray:
    """Distance from a point to the nearest wall along each angle, inf where there is none."""
    nearest = np.full(len(angles), np.inf)
    along_x, along_y = np.cos(angles), np.sin(angles)
    for x1, y1, x2, y2 in walls:
        wall_x, wall_y = x2 - x1, y2 - y1
        cross = along_x * wall_y - along_y * wall_x
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = ((x1 - x) * wall_y - (y1 - y) * wall_x) / cross
            where = ((x1 - x) * along_y - (y1 - y) * along_x) / cross
        hit = (distance > 0.0) & (where >= 0.0) & (where <= 1.0)
        nearest[hit] = np.minimum(nearest[hit], distance[hit])
    return nearest
