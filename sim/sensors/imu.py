"""The inertial sensor: turn rate and acceleration with noise, attitude without."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from typing_extensions import override

from sim.physics.names import ACCELEROMETER, BASE
from sim.sensors import topics
from sim.sensors.sensor import Mount, Noise, Sensor


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


class Imu(Sensor):
    """Reads the model's accelerometer, and the base's turn rate and attitude."""

    name = "imu"
    topic = topics.IMU
    message = "sensor_msgs/msg/Imu"
    frame = "imu_link"

    def __init__(self, mount: Mount) -> None:
        super().__init__(mount)
        model, prefix = mount.physics.model, mount.prefix
        noisy, spec = mount.robot.sensors.imu.noise, self.spec
        self._sigmas = (spec.gyro_noise, spec.accel_noise) if noisy else (0.0, 0.0)
        self._address = int(model.sensor(prefix + ACCELEROMETER).adr[0])
        self._noise = Noise(mount.seed, f"{prefix}imu", 6)
        joint = model.joint(prefix + BASE)
        self._q, self._v = int(joint.qposadr[0]) + 3, int(joint.dofadr[0]) + 3
        self._start = math.cos(mount.start_yaw / 2), math.sin(mount.start_yaw / 2)
        self.fields = (
            *(f"orientation.{axis}" for axis in "xyzw"),
            *(f"angular_velocity.{axis}" for axis in "xyz"),
            *(f"linear_acceleration.{axis}" for axis in "xyz"),
        )

    @override
    def constants(self) -> Mapping[str, Any]:
        # Covariances of independent axes.
        return {
            "angular_velocity_covariance": np.diag([self.spec.gyro_noise**2] * 3).ravel(),
            "linear_acceleration_covariance": np.diag([self.spec.accel_noise**2] * 3).ravel(),
        }

    @override
    def numbers(self, index: int) -> tuple[float, ...]:
        reading = self.measure(index)
        w, *axes = reading.orientation
        return (*axes, w, *reading.angular_velocity, *reading.linear_acceleration)

    def measure(self, index: int) -> Inertial:
        """Return measurement `index`. The acceleration is that of the last physics step."""
        data = self.mount.physics.data
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
