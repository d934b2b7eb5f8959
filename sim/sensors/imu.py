"""The inertial sensor: turn rate and acceleration with noise, attitude without."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco

from bt_mission.core.robot.model import RobotModel
from sim.physics.names import ACCELEROMETER, BASE
from sim.sensors.noise import Noise


@dataclass(frozen=True, slots=True)
class Inertial:
    """One reading, in the axes of the base.

    `orientation` is w, x, y, z since the start: an IMU does not know where the map's x axis is.
    `angular_velocity` in rad/s; `linear_acceleration` in m/s^2, with gravity, so (0, 0, 9.81) at
    rest.
    """

    orientation: tuple[float, float, float, float]
    angular_velocity: tuple[float, float, float]
    linear_acceleration: tuple[float, float, float]


class Imu:
    """Reads the model's accelerometer, and the base's turn rate and attitude."""

    def __init__(
        self, model: mujoco.MjModel, robot: RobotModel, seed: int, start_yaw: float, prefix: str
    ) -> None:
        noisy, spec = robot.sensors.imu.noise, robot.imu
        self._sigmas = (spec.gyro_noise, spec.accel_noise) if noisy else (0.0, 0.0)
        self._address = int(model.sensor(prefix + ACCELEROMETER).adr[0])
        self._noise = Noise(seed, f"{prefix}imu", 6)
        joint = model.joint(prefix + BASE)
        self._q, self._v = int(joint.qposadr[0]) + 3, int(joint.dofadr[0]) + 3
        self._start = math.cos(start_yaw / 2), math.sin(start_yaw / 2)

    def measure(self, data: mujoco.MjData, index: int) -> Inertial:
        """Return measurement `index`. The acceleration is that of the last physics step."""
        g, a = self._sigmas
        n = self._noise.at(index).tolist()
        w, x, y, z = data.qpos[self._q : self._q + 4].tolist()
        rate_x, rate_y, rate_z = data.qvel[self._v : self._v + 3].tolist()
        at = self._address
        ax, ay, az = data.sensordata[at : at + 3].tolist()
        c, s = self._start
        return Inertial(
            (c * w + s * z, c * x + s * y, c * y - s * x, c * z - s * w),
            (rate_x + g * n[0], rate_y + g * n[1], rate_z + g * n[2]),
            (ax + a * n[3], ay + a * n[4], az + a * n[5]),
        )
