"""The numbers of a robot: limits, body and sensors, in SI units, from one file per model.

`robots/NAME.yaml` holds them, each with its source. Frames follow REP 103: x forward, y left,
z up; positions are those of `base_link`, below the middle of the axle.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

from pydantic import Field, model_validator

from bt_mission.core import files
from bt_mission.core.robot import parts
from bt_mission.core.yaml.document import Document, read
from bt_mission.core.yaml.models import validate

_TOLERANCE = 1e-6
"""Metres by which figures that follow from each other may differ."""


class RobotModel(parts.RobotPart):
    """A differential-drive robot; see `robots/*.yaml` for units and sources of every number.

    `wheel_separation` is the one control and odometry reckon with, `2 * wheel_y` the real one.
    """

    name: Annotated[str, Field(min_length=1)]
    max_linear_velocity: parts.Positive
    max_angular_velocity: parts.Positive
    max_linear_acceleration: parts.Positive
    max_angular_acceleration: parts.Positive
    command_timeout: parts.Positive = 0.2
    control_rate: parts.Positive = 20.0
    wheel_radius: parts.Positive
    wheel_width: parts.Positive
    wheel_separation: parts.Positive
    wheel_y: parts.Positive
    base_height: parts.Positive
    base_mass: parts.Positive
    base_inertia: parts.Size3
    base_centre_of_mass: parts.Point3
    wheel_mass: parts.Positive
    wheel_inertia: parts.Size3
    body: parts.Body
    caster_radius: parts.Positive
    casters: Annotated[tuple[parts.Point3, ...], Field(min_length=1)]
    hull: parts.Hull
    odometry_rate: parts.Positive = 20.0
    lidar: parts.LidarModel
    camera: parts.CameraModel | None = None
    imu: parts.ImuModel
    battery: parts.BatteryModel = parts.BatteryModel()
    sensors: parts.SensorsModel = parts.SensorsModel()

    def with_sensors(self, sensors: parts.SensorsModel) -> RobotModel:
        """Return the same robot with its simulated sensors set so."""
        model = sensors.lidar.model
        lidar = self.lidar if model is None else self.lidar.as_model(model)
        return self.model_copy(update={"sensors": sensors, "lidar": lidar})

    @property
    def turning_radius(self) -> float:
        """The circle that the body sweeps when it turns on the spot, m from the axle's middle."""
        (length, width, _), (x, y, _) = self.body.size, self.body.centre
        corner = math.hypot(abs(x) + length / 2, abs(y) + width / 2)
        return max(corner, math.hypot(self.wheel_radius, self.hull.half_width))

    @model_validator(mode="after")
    def _hull_holds_body_and_wheels(self) -> RobotModel:
        (length, width, _), (x, y, _) = self.body.size, self.body.centre
        around = {
            "front": max(x + length / 2, self.wheel_radius),
            "rear": min(x - length / 2, -self.wheel_radius),
            "half_width": max(abs(y) + width / 2, self.wheel_y + self.wheel_width / 2),
        }
        for field, expected in around.items():
            got = getattr(self.hull, field)
            if abs(got - expected) > _TOLERANCE:
                raise ValueError(
                    f"hull.{field} must be {expected:.4g} m, which body and wheels reach, got {got}"
                )
        return self


def load_robot(name_or_path: str | Path | Document, near: str | Path | None = None) -> RobotModel:
    """Return the model of a robot, by its name or file, or of its text.

    Raises InputError with every fault and its place.

    `near` is a file beside which a robot of that name is looked for first, such as a mission.
    """
    document = name_or_path
    if not isinstance(document, Document):
        document = read(files.find("robots", document, near))
    robot = validate(document, RobotModel)
    return robot.with_sensors(robot.sensors)
