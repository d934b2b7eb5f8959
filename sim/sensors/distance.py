"""Sensors of one distance: sonar, infrared, and what looks for cliffs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from typing_extensions import override

from bt_mission.robots.model import RobotModel
from sim.frames import BASE_LINK, FramePose
from sim.physics.names import BASE
from sim.sensors import topics
from sim.sensors.lidar import Rays
from sim.sensors.sensor import Mount, Noise, Sensor

_RAYS = 9
"""Rays across the field of view of a level sensor; a cliff sensor has one."""

_ULTRASOUND, _INFRARED = 0, 1


class RangeSensor(Sensor):
    """The distance of the nearest thing in the field of view.

    Nearer than its least range reads -inf, and where there is nothing it reads inf (REP 117).
    """

    name = "range"
    table = "range_sensors"
    topic = topics.RANGE
    message = "sensor_msgs/msg/Range"
    frame = "range"

    def __init__(self, mount: Mount) -> None:
        super().__init__(mount)
        physics, spec = mount.physics, self.spec
        directions = np.array([[0.0, 0.0, -1.0]])
        if spec.kind != "cliff":
            half = math.radians(spec.field_of_view) / 2
            angles = math.radians(spec.yaw) + np.linspace(-half, half, _RAYS)
            directions = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
        base = physics.model.body(mount.prefix + BASE).id
        self._rays = Rays(physics.model, base, (spec.x, spec.y, spec.z), directions)
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
        spec = self.spec
        distances, missed = self._rays.cast(self.mount.physics.data, len(self._rays.directions))
        distance = float(distances[~missed].min(initial=math.inf))
        distance += spec.noise_std * float(self._noise.at(index)[0])
        if distance < spec.min_range:
            return (-math.inf,)
        return (distance if distance <= spec.max_range else math.inf,)
