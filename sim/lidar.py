"""The lidar: distances to what stands around, one ray per direction, all at one instant."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import numpy.typing as npt

from bt_mission.common.robot import RobotModel
from sim.names import BASE, MARKS, SOLID
from sim.noise import Noise


class Lidar:
    """A planar lidar on the base. Ray 0 looks ahead, the others follow counter-clockwise."""

    def __init__(self, model: mujoco.MjModel, robot: RobotModel, seed: int) -> None:
        spec = robot.lidar
        self._spec = spec
        self._model = model
        self._base = model.body(BASE).id
        self._offset = np.array([spec.x, spec.y, spec.z])
        angles = np.arange(spec.rays) * (math.tau / spec.rays)
        self._directions = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(spec.rays)))
        self._vectors = np.empty_like(self._directions)
        self._flat = self._vectors.reshape(-1)
        self._distances = np.empty(spec.rays)
        self._hit = np.empty(spec.rays, dtype=np.int32)
        self._groups = np.zeros(mujoco.mjNGROUP, dtype=np.uint8)
        self._groups[[SOLID, MARKS]] = 1
        self._noise = Noise(seed, "lidar", spec.rays)

    def measure(
        self, data: mujoco.MjData, index: int, out: npt.NDArray[np.float32] | None = None
    ) -> npt.NDArray[np.float32]:
        """Return the ranges in metres of measurement `index`; positions in `data` must be current.

        Farther than `max_range` reads inf, as in Gazebo; nearer than `min_range` reads 0.0, as
        from the driver of the LDS-01.
        """
        spec = self._spec
        rotation = data.xmat[self._base].reshape(3, 3)
        np.matmul(self._directions, rotation.T, out=self._vectors)
        mujoco.mj_multiRay(
            self._model,
            data,
            data.xpos[self._base] + rotation @ self._offset,
            self._flat,
            self._groups,
            1,  # static geoms too
            -1,  # no body left out: the robot's geoms are in groups that are
            self._hit,
            self._distances,
            None,
            spec.rays,
            mujoco.mjMAXVAL,
        )
        seen = self._distances
        missed = self._hit < 0
        seen += spec.noise_std * self._noise.at(index)
        near = seen < spec.min_range
        missed |= seen > spec.max_range
        seen[near] = 0.0
        seen[missed] = np.inf
        if out is None:
            return seen.astype(np.float32)
        out[:] = seen
        return out
