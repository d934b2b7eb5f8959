"""The parts of a robot, in figures: body, hull, sensors and battery, SI units."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

Number = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Error = Annotated[float, Field(ge=-0.5, le=0.5, allow_inf_nan=False)]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Point3 = tuple[Number, Number, Number]
Size3 = tuple[Positive, Positive, Positive]
LidarName = Literal["LDS-01", "LDS-02"]


LDS_02_SAMPLES = 2300.0
"""Readings a second of an LDS-02, however fast it turns [ROBOTIS e-manual]."""


class RobotPart(BaseModel):
    """Figures of a part: fixed, and none that nobody knows."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


class Body(RobotPart):
    """The box that stands for the body: edges along x, y, z and centre, m."""

    size: Size3
    centre: Point3


class Hull(RobotPart):
    """The rectangle around body and wheels, seen from above: m from the middle of the axle."""

    front: Positive
    rear: Annotated[float, Field(lt=0, allow_inf_nan=False)]
    half_width: Positive


class MountedSensor(RobotPart):
    """A sensor at a place (m), with its rate (Hz)."""

    x: Number
    y: Number
    z: Number
    rate: Positive


class LidarModel(MountedSensor):
    """A planar lidar: place (m), ranges (m), rays per turn, rate (Hz), noise (m, 1 sigma).

    `model` decides what it says of a direction without a reading, and whether the number of rays
    varies (an LDS-02's does, about `rays`).
    """

    min_range: NotNegative
    max_range: Positive
    rays: Annotated[int, Field(ge=1, le=10_000)]
    noise_std: NotNegative
    model: LidarName = "LDS-01"

    @model_validator(mode="after")
    def _ranges_in_order(self) -> LidarModel:
        if self.min_range >= self.max_range:
            raise ValueError(
                f"min_range {self.min_range} m must be below max_range {self.max_range} m"
            )
        return self

    def as_model(self, model: LidarName) -> LidarModel:
        """Return a lidar of that model at the same place and rate. Figures: ROBOTIS e-manual."""
        if model == "LDS-01":
            figures = {"min_range": 0.12, "max_range": 3.5, "rays": 360}
        else:
            rays = max(1, round(LDS_02_SAMPLES / self.rate))
            figures = {"min_range": 0.16, "max_range": 8.0, "rays": rays}
        return self.model_copy(update={"model": model, **figures})


class CameraModel(MountedSensor):
    """A camera that looks ahead: place of its lens and of `camera_link` (m), picture, rate (Hz).

    `width` and `height` are pixels, `hfov` the horizontal field of view in radians.
    """

    link: Point3
    width: Annotated[int, Field(ge=16, le=3840)]
    height: Annotated[int, Field(ge=16, le=2160)]
    hfov: Annotated[float, Field(gt=0, lt=math.pi, allow_inf_nan=False)]


class ImuModel(MountedSensor):
    """Gyroscope and accelerometer: place (m), rate (Hz), noise (rad/s and m/s^2, 1 sigma)."""

    gyro_noise: NotNegative
    accel_noise: NotNegative


class BatteryModel(RobotPart):
    """The battery: capacity (Ah), voltages (V), and what is drawn from it.

    `idle_power` (W) is drawn all the time, `drive_energy` (J) for each radian that a wheel turns;
    `start_charge` is what it begins with, as a share of the full charge. Defaults are the LiPo
    of a TurtleBot3, and what empties it in 2 h of driving at full speed, 2.9 h of standing.
    """

    capacity: Positive = 1.8
    nominal_voltage: Positive = 11.1
    empty_voltage: Positive = 10.5
    full_voltage: Positive = 12.3
    start_charge: Share = 1.0
    idle_power: NotNegative = 7.0
    drive_energy: NotNegative = 0.19

    @model_validator(mode="after")
    def _voltages_in_order(self) -> BatteryModel:
        if self.empty_voltage >= self.full_voltage:
            raise ValueError(
                f"empty_voltage {self.empty_voltage} V must be below"
                f" full_voltage {self.full_voltage} V"
            )
        return self


class LidarOptions(RobotPart):
    """Which lidar is mounted (None: as the robot's figures say), and whether it is noisy."""

    model: LidarName | None = None
    noise: bool = True


class NoiseOption(RobotPart):
    """Whether a sensor is noisy."""

    noise: bool


class OdometryOptions(RobotPart):
    """How odometry drifts: relative errors of the figures it reckons with, and slip.

    `wheel_radius_error` 0.01: it takes wheels for 1 % larger than they are. `slip`: the mean
    share of a wheel's turning that moves nothing.
    """

    wheel_radius_error: Error = 0.0
    wheel_separation_error: Error = 0.0
    slip: Annotated[float, Field(ge=0, le=0.5, allow_inf_nan=False)] = 0.0


class SensorsModel(RobotPart):
    """Options of the simulated sensors, apart from where they sit. Noise is seeded."""

    lidar: LidarOptions = LidarOptions()
    imu: NoiseOption = NoiseOption(noise=True)
    camera: NoiseOption = NoiseOption(noise=False)
    odometry: OdometryOptions = OdometryOptions()
