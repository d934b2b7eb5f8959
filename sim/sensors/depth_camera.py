"""The depth camera: the distance along its axis of what each pixel shows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from typing_extensions import override

from bt_mission.robots.model import RobotModel
from sim.faults import SensorFaults
from sim.frames import BASE_LINK, FramePose
from sim.physics.names import BASE
from sim.sensors import topics
from sim.sensors.camera import OPTICAL, CameraInfoSensor, image
from sim.sensors.lidar import Rays
from sim.sensors.sensor import Mount, PictureNoise, Sensor

FRAME = "camera_depth_frame"
OPTICAL_FRAME = "camera_depth_optical_frame"


class DepthInfoSensor(CameraInfoSensor):
    """The calibration of a depth camera: a pinhole without distortion, square pixels."""

    name = "depth_camera"
    topic = topics.DEPTH_INFO
    frame = OPTICAL_FRAME
    breaks = SensorFaults()


class DepthCameraSensor(Sensor):
    """Depths in m as 32FC1 (REP 118), measured by one ray for each pixel, without a GPU.

    Nearer than its least range reads -inf, farther than its largest inf.
    """

    name = "depth_camera"
    topic = topics.DEPTH_IMAGE
    message = "sensor_msgs/msg/Image"
    frame = OPTICAL_FRAME
    is_camera = True

    def __init__(self, mount: Mount) -> None:
        super().__init__(mount)
        spec, physics = self.spec, mount.physics
        pixel = 2 * math.tan(spec.hfov / 2) / spec.width
        left = (spec.width / 2 - np.arange(spec.width) - 0.5) * pixel
        up = (spec.height / 2 - np.arange(spec.height) - 0.5) * pixel
        across, high = np.meshgrid(left, up)
        rays = np.stack((np.ones_like(across), across, high), axis=-1).reshape(-1, 3)
        lengths = np.linalg.norm(rays, axis=1)
        self._along = 1 / lengths
        base = physics.model.body(mount.prefix + BASE).id
        place = (spec.x, spec.y, spec.z)
        self._rays = Rays(physics.model, base, place, rays / lengths[:, None])
        self._noise = PictureNoise(mount.seed, f"{mount.prefix}depth_camera")

    @classmethod
    @override
    def frames(cls, robot: RobotModel) -> list[FramePose]:
        spec = cls.figures(robot)
        return [
            FramePose(BASE_LINK, FRAME, (spec.x, spec.y, spec.z)),
            FramePose(FRAME, OPTICAL_FRAME, (0.0, 0.0, 0.0), OPTICAL),
        ]

    @override
    def constants(self) -> Mapping[str, Any]:
        return image(self.spec, "32FC1", 4)

    @override
    def fill(self, message: Any, index: int) -> bool:
        """Measure into the message, in place."""
        np.frombuffer(message.data, np.float32)[:] = self.measure(index)
        return True

    def measure(self, index: int) -> npt.NDArray[np.float64]:
        """Return the depth of each pixel of image `index`, m, row by row."""
        spec, count = self.spec, len(self._along)
        distances, missed = self._rays.cast(self.mount.physics.data, count)
        depths: npt.NDArray[np.float64] = distances * self._along
        if spec.noise_std:
            depths += spec.noise_std * depths**2 * self._noise.normal(count, index)
        near = depths < spec.min_range
        missed |= depths > spec.max_range
        depths[near], depths[missed] = -np.inf, np.inf
        return depths
