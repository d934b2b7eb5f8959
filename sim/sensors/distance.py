"""Sensors of one distance: sonar, infrared, and what looks for cliffs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np
from typing_extensions import override

from bt_mission.core.robot.model import RobotModel
from sim.frames import BASE_LINK, FramePose
from sim.physics.names import BASE, MARKS, SCREENS, SOLID
from sim.sensors.noise import Noise
from sim.sensors.sensor import Mount, Sensor

_RAYS = 9
"""Rays across the field of view of a level sensor; a cliff sensor has one."""

_ULTRASOUND, _INFRARED = 0, 1


class RangeSensor(Sensor):
    """The distance of the nearest thing in the field of view.

    Nearer than its least range reads -inf, and where there is nothing it reads inf (REP 117).
    """

    name = "range"
    table = "range_sensors"
    topic = "range"
    message = "sensor_msgs/msg/Range"
    frame = "range"

    def __init__(self, mount: Mount) -> None:
        super().__init__(mount)
        physics, spec = mount.physics, self.spec
        self._base = physics.model.body(mount.prefix + BASE).id
        self._offset = np.array([spec.x, spec.y, spec.z])
        self._directions = np.array([[0.0, 0.0, -1.0]])
        if spec.kind != "cliff":
            half = math.radians(spec.field_of_view) / 2
            angles = math.radians(spec.yaw) + np.linspace(-half, half, _RAYS)
            self._directions = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
        count = len(self._directions)
        self._hit, self._distances = np.empty(count, dtype=np.int32), np.empty(count)
        self._groups = np.zeros(mujoco.mjNGROUP, dtype=np.uint8)
        self._groups[[SOLID, MARKS, SCREENS]] = 1
        self._noise = Noise(mount.seed, f"{mount.prefix}{self.name}", 1)
        self.fields = ("range",)

    @classmethod
    @override
    def frames(cls, robot: RobotModel) -> list[FramePose]:
        """Return its frame, whose x axis is the direction in which it looks."""
        spec = cls.figures(robot)
        half = math.radians(spec.yaw) / 2
        rotation = (0.0, 0.0, math.sin(half), math.cos(half))
        if spec.kind == "cliff":
            rotation = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))
        return [FramePose(BASE_LINK, cls.frame, (spec.x, spec.y, spec.z), rotation)]

    @override
    def constants(self) -> Mapping[str, Any]:
        spec = self.spec
        return {
            "radiation_type": _ULTRASOUND if spec.kind == "sonar" else _INFRARED,
            "field_of_view": math.radians(spec.field_of_view),
            "min_range": spec.min_range,
            "max_range": spec.max_range,
        }

    @override
    def numbers(self, index: int) -> tuple[float]:
        spec, physics = self.spec, self.mount.physics
        data = physics.data
        rotation = data.xmat[self._base].reshape(3, 3)
        mujoco.mj_multiRay(
            physics.model,
            data,
            data.xpos[self._base] + rotation @ self._offset,
            (self._directions @ rotation.T).ravel(),
            self._groups,
            1,  # static geoms too
            self._base,
            self._hit,
            self._distances,
            None,
            len(self._hit),
            mujoco.mjMAXVAL,
        )
        distance = float(self._distances[self._hit >= 0].min(initial=math.inf))
        distance += spec.noise_std * float(self._noise.at(index)[0])
        if distance < spec.min_range:
            return (-math.inf,)
        return (distance if distance <= spec.max_range else math.inf,)
