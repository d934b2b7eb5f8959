"""IR-SIM, a two-dimensional simulator (PyPI: ir-sim), in place of MuJoCo's steps.

    bt-mission run patrol --simulator sim.ir_sim:IrSim

It shows what another simulator needs: see `sim.physics.simulator`. Footprints are exact; heights,
friction and mass are not simulated. Contacts are rigid: a wall stops the robot.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt
import yaml

from bt_mission.core.robot.model import RobotModel
from sim.physics.simulator import Pose
from sim.world.shapes import Obstacle
from sim.world.world import World

os.environ.setdefault("MPLBACKEND", "Agg")  # it imports Matplotlib, which would look for a display

import irsim  # noqa: E402 - after the choice of the backend

STEP_NS = 50_000_000
_MARGIN_M = 1.0
"""Beyond the floor, so that no wall ends at the edge."""


class IrSim:
    """A world of IR-SIM with one robot."""

    step_ns = STEP_NS

    def __init__(self, *, world: World, robot: RobotModel, start: Pose, seed: int) -> None:
        if world.slippery:
            raise ValueError(f"the world '{world.name}' has slippery patches: IR-SIM has no friction")
        self._moving = world.moving
        self._names = {obstacle.name: f"obstacle_{n}" for n, obstacle in enumerate(world.obstacles)}
        with TemporaryDirectory(prefix="bt_mission_") as folder:
            file = Path(folder) / "world.yaml"
            file.write_text(yaml.safe_dump(self._scene(world, robot, start)), encoding="utf-8")
            self._env: Any = irsim.make(str(file), display=False, seed=seed, log_level="ERROR")
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
        """Make steps of 50 ms with a velocity."""
        while self.time_ns < time_ns:
            self.time_ns += STEP_NS
            self._place_moving()
            self._env.step(np.array([[linear], [angular]]))

    def ranges(self) -> Sequence[float]:
        """Return the distances of all rays, ahead first."""
        self._lidar.step(self._env.robot.state[:3])
        measured: npt.NDArray[np.float64] = self._lidar.range_data
        distances = np.where(self._lidar.valid, measured, np.inf)
        return distances[: self._rays].tolist()  # the last ray looks where the first one does

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
        hull, lidar = robot.hull, robot.lidar
        corners = [(x, hull.half_width) for x in (hull.front, hull.rear)]
        outline = [*corners, *((x, -y) for x, y in reversed(corners))]
        return {
            "world": {
                "width": length,
                "height": width,
                "offset": [-length / 2, -width / 2],
                "step_time": STEP_NS / 1e9,
                "sample_time": STEP_NS / 1e9,
                "collision_mode": "contact",
            },
            "robot": [
                {
                    "kinematics": {"name": "diff"},
                    "shape": {"name": "polygon", "vertices": [list(corner) for corner in outline]},
                    "state": list(start),
                    "vel_min": [-robot.max_linear_velocity, -robot.max_angular_velocity],
                    "vel_max": [robot.max_linear_velocity, robot.max_angular_velocity],
                    "sensors": [
                        {
                            "name": "lidar2d",
                            "range_min": 0.0,
                            "range_max": lidar.max_range + 1.0,
                            "angle_range": math.tau,
                            "number": lidar.rays + 1,
                            "offset": [lidar.x, lidar.y, math.pi],  # so the first ray looks ahead
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
