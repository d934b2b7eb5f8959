"""IR-SIM, a two-dimensional simulator (PyPI: ir-sim), in place of MuJoCo's steps.

    bt-mission run patrol --simulator sim.ir_sim:IrSim

It shows what another simulator needs: see `sim.physics.simulator`. Footprints are exact; heights,
friction and mass are not simulated. Contacts are rigid: a wall stops the robot.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt

from bt_mission.base.output import write_file
from bt_mission.robots.body import CylinderBody, PolygonBody
from bt_mission.robots.model import RobotModel
from sim.physics.simulator import Pose, periods_ns
from sim.world.shapes import Obstacle
from sim.world.world import World

try:
    with redirect_stdout(StringIO()):  # it prints which windows of Matplotlib do not open
        import irsim
except ImportError as error:
    raise ImportError("IR-SIM is not installed; pip install 'bt-mission[ir-sim]'") from error

LONGEST_NS = 50_000_000
"""The length of a step, or the longest that fits all sensors, ns."""

_MARGIN_M = 1.0
"""Beyond the floor, so that no wall ends at the edge."""

_CORNERS = 32
"""Corners of a round robot."""


class IrSim:
    """A world of IR-SIM with one robot."""

    def __init__(self, *, world: World, robot: RobotModel, start: Pose, seed: int) -> None:
        if world.slippery:
            raise ValueError(
                f"the world '{world.name}' has slippery patches: IR-SIM has no friction"
            )
        self.step_ns = math.gcd(LONGEST_NS, *periods_ns(robot).values())
        self._moving = world.moving
        self._names = {obstacle.name: f"obstacle_{n}" for n, obstacle in enumerate(world.obstacles)}
        with TemporaryDirectory(prefix="bt_mission_") as folder:
            file = Path(folder) / "world.yaml"
            write_file(file, json.dumps(self._scene(world, robot, start)))
            self._env: Any = irsim.make(str(file), headless=True, seed=seed, log_level="ERROR")
        # Taken from the robot, so that it measures when a scan is due, and not at each step.
        self._lidar: Any = self._env.robot.sensors.pop()
        self._rays = robot.lidar.rays
        self.time_ns = 0

    @property
    def pose(self) -> Pose:
        """The pose of the middle of the axle."""
        x, y, yaw = self._env.robot.state[:3, 0].tolist()
        return x, y, yaw

    def advance_to(self, time_ns: int, linear: float, angular: float) -> None:
        """Make steps with a velocity."""
        while self.time_ns < time_ns:
            self.time_ns += self.step_ns
            self._place_moving()
            self._env.step(np.array([[linear], [angular]]))

    def ranges(self) -> Sequence[float]:
        """Return the distances of all rays, ahead first."""
        self._lidar.step(self._env.robot.state[:3])
        measured: npt.NDArray[np.float64] = self._lidar.range_data
        distances = np.where(self._lidar.valid, measured, np.inf)
        ranges: list[float] = distances[: self._rays].tolist()
        return ranges

    def reset(self) -> None:
        """Put all to the start."""
        self.time_ns = 0
        self._env.reset()
        self._place_moving()

    def _place_moving(self) -> None:
        for obstacle in self._moving:
            assert obstacle.motion is not None
            x, y, _, _ = obstacle.motion.at(self.time_ns / 1e9)
            moved = self._env.get_object_by_name(self._names[obstacle.name])
            moved.set_state([x, y, obstacle.yaw])

    def _scene(self, world: World, robot: RobotModel, start: Pose) -> dict[str, Any]:
        """Return a world in IR-SIM's notation."""
        length, width = (extent + 2 * _MARGIN_M for extent in world.size)
        lidar = robot.lidar
        first, step = lidar.angles
        middle = math.radians(lidar.yaw) + first + step * lidar.rays / 2
        return {
            "world": {
                "width": length,
                "height": width,
                "offset": [-length / 2, -width / 2],
                "step_time": self.step_ns / 1e9,
                "sample_time": self.step_ns / 1e9,
                "collision_mode": "contact",
            },
            "robot": [
                {
                    "kinematics": {"name": "diff"},
                    "shape": {"name": "polygon", "vertices": _outline(robot)},
                    "state": list(start),
                    "vel_min": [-robot.max_linear_velocity, -robot.max_angular_velocity],
                    "vel_max": [robot.max_linear_velocity, robot.max_angular_velocity],
                    "sensors": [
                        {
                            "name": "lidar2d",
                            "range_min": 0.0,
                            "range_max": lidar.max_range + 1.0,
                            # One ray more than the lidar has: it is left out of the ranges.
                            "angle_range": step * lidar.rays,
                            "number": lidar.rays + 1,
                            "offset": [lidar.x, lidar.y, middle],
                        }
                    ],
                }
            ],
            "obstacle": [self._obstacle(obstacle) for obstacle in world.obstacles],
        }

    def _obstacle(self, obstacle: Obstacle) -> dict[str, Any]:
        size_x, size_y, _ = obstacle.size
        shape: dict[str, Any] = {"name": "rectangle", "length": size_x, "width": size_y}
        if obstacle.kind == "cylinder":
            shape = {"name": "circle", "radius": obstacle.radius}
        state = [obstacle.x, obstacle.y, obstacle.yaw]
        return {"name": self._names[obstacle.name], "shape": shape, "state": state}


def _outline(robot: RobotModel) -> list[list[float]]:
    """Return the corners of the robot seen from above, m: body and wheels."""
    hull, body = robot.hull, robot.body
    if isinstance(body, PolygonBody):
        return [[x, y] for x, y in body.outline]
    if isinstance(body, CylinderBody):
        turns = [math.tau * n / _CORNERS for n in range(_CORNERS)]
        x, y, _ = body.centre
        return [
            [x + body.radius * math.cos(turn), y + body.radius * math.sin(turn)] for turn in turns
        ]
    left = [[hull.front, hull.half_width], [hull.rear, hull.half_width]]
    return [*left, *([x, -y] for x, y in reversed(left))]
