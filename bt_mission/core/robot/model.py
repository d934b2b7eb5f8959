"""The figures of a robot: limits, body, sensors and battery, in SI units, from one file per model.

`robots/NAME.yaml` holds them, each with its source. Frames follow REP 103: x forward, y left, z up;
positions are those of `base_link`, below the middle of the axle.
"""

from __future__ import annotations

import math
from functools import cached_property
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from bt_mission.core import files
from bt_mission.core.robot.body import Body, Hull
from bt_mission.core.robot.drives import Drive
from bt_mission.core.robot.parts import (
    NotNegative,
    Number,
    Point3,
    Positive,
    RobotPart,
    Size3,
)
from bt_mission.core.yaml.document import Document, read
from bt_mission.core.yaml.models import validate

_WHOLE_DIGITS = 9
"""Decimals of a hull in m: without the error of a sum."""

Error = Annotated[float, Field(ge=-0.5, le=0.5, allow_inf_nan=False)]
Bearing = Annotated[float, Field(ge=-360, le=360, allow_inf_nan=False)]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
LidarKey = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,19}$")]
LidarName = Literal["LDS-01", "LDS-02"]

LDS_02_SAMPLES = 2300.0
"""Readings a second of an LDS-02, however fast it turns [ROBOTIS e-manual]."""


class MountedSensor(RobotPart):
    """A sensor at a place (m), with its rate (Hz)."""

    x: Number
    y: Number
    z: Number
    rate: Positive


class LidarModel(MountedSensor):
    """A planar lidar: place, ranges (m), rays per scan, rate, noise (1 sigma).

    `yaw` is the bearing of its ray 0, deg. `sector` are the bearings of its first and its last ray
    from there, deg, left positive; without it, it measures a full turn. With `model` LDS-02 the
    number of rays varies around `rays`.
    """

    min_range: NotNegative
    max_range: Positive
    rays: Annotated[int, Field(ge=1, le=10_000)]
    noise_std: NotNegative
    model: LidarName = "LDS-01"
    yaw: Annotated[float, Field(ge=-360, le=360, allow_inf_nan=False)] = 0.0
    sector: tuple[Bearing, Bearing] | None = None

    @model_validator(mode="after")
    def _ranges_in_order(self) -> LidarModel:
        if self.min_range >= self.max_range:
            raise ValueError(
                f"min_range {self.min_range} m must be below max_range {self.max_range} m"
            )
        return self

    @model_validator(mode="after")
    def _sector_in_order(self) -> LidarModel:
        if self.sector is None:
            return self
        first, last = self.sector
        if not 0 < last - first < 360:
            raise ValueError(
                f"sector must reach from a smaller to a larger bearing, less than a full turn,"
                f" got {first:g} to {last:g} deg; leave it out for a full turn"
            )
        if self.rays < 2 or self.model == "LDS-02":
            raise ValueError("a sector has two rays or more; an LDS-02 measures a full turn")
        return self

    @property
    def angles(self) -> tuple[float, float]:
        """The bearing of the first ray in the frame of the lidar, and the step to the next, rad."""
        if self.sector is None:
            return 0.0, math.tau / self.rays
        first, last = self.sector
        return math.radians(first), math.radians(last - first) / (self.rays - 1)

    def as_model(self, model: LidarName) -> LidarModel:
        """Return a lidar of that model at the same place and rate. Figures: ROBOTIS e-manual."""
        if model == "LDS-01":
            figures = {"min_range": 0.12, "max_range": 3.5, "rays": 360}
        else:
            rays = max(1, round(LDS_02_SAMPLES / self.rate))
            figures = {"min_range": 0.16, "max_range": 8.0, "rays": rays}
        return self.model_copy(update={"model": model, **figures})


class CameraModel(MountedSensor):
    """A camera that faces forward: place of its lens, of `camera_link`, image size, rate.

    `width` and `height` in pixels, `hfov` the horizontal field of view.
    """

    link: Point3
    width: Annotated[int, Field(ge=16, le=3840)]
    height: Annotated[int, Field(ge=16, le=2160)]
    hfov: Annotated[float, Field(gt=0, lt=math.pi, allow_inf_nan=False)]


class ImuModel(MountedSensor):
    """Gyroscope and accelerometer: place, rate, noise (rad/s and m/s^2, 1 sigma)."""

    gyro_noise: NotNegative
    accel_noise: NotNegative


class BatteryModel(RobotPart):
    """The battery: capacity (Ah), voltages (V), consumption.

    `idle_power` (W) is always drawn, `drive_energy` (J) for each radian of a wheel. Defaults: the
    LiPo of a TurtleBot3, which lasts for 2 h at full speed or 2.9 h at rest.
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
    """The mounted lidar (default: that of `lidar`), and whether it is noisy."""

    model: LidarName | None = None
    noise: bool = True


class NoiseOption(RobotPart):
    """Whether a sensor is noisy."""

    noise: bool


class OdometryOptions(RobotPart):
    """The drift of odometry: relative errors of its parameters, and slip.

    `slip`: the mean share of a wheel's rotation without motion.
    """

    wheel_radius_error: Error = 0.0
    wheel_separation_error: Error = 0.0
    slip: Annotated[float, Field(ge=0, le=0.5, allow_inf_nan=False)] = 0.0


class SensorsModel(RobotPart):
    """Options of the simulated sensors. Noise is seeded."""

    lidar: LidarOptions = LidarOptions()
    imu: NoiseOption = NoiseOption(noise=True)
    camera: NoiseOption = NoiseOption(noise=False)
    odometry: OdometryOptions = OdometryOptions()


class RobotModel(RobotPart):
    """A mobile base, in m, s, kg, rad and Hz unless another unit is named.

    `robots/*.yaml` has the source of every number. `lidars` are further lidars by their names: a
    lidar `rear` publishes the topic `scan_rear` in the frame `base_scan_rear`.
    """

    name: Annotated[str, Field(min_length=1)]
    max_linear_velocity: Positive
    max_angular_velocity: Positive
    max_linear_acceleration: Positive
    max_angular_acceleration: Positive
    command_timeout: Positive = 0.2
    control_rate: Positive = 20.0
    drive: Drive
    base_height: NotNegative
    base_mass: Positive
    base_inertia: Size3
    base_centre_of_mass: Point3
    body: Body
    odometry_rate: Positive = 20.0
    lidar: LidarModel
    lidars: dict[LidarKey, LidarModel] = Field(default_factory=dict)
    camera: CameraModel | None = None
    imu: ImuModel
    battery: BatteryModel = BatteryModel()
    sensors: SensorsModel = SensorsModel()

    def with_sensors(self, sensors: SensorsModel) -> RobotModel:
        """Return the same robot with its simulated sensors set so."""
        model = sensors.lidar.model
        lidar = self.lidar if model is None else self.lidar.as_model(model)
        return self.model_copy(update={"sensors": sensors, "lidar": lidar})

    @cached_property
    def passing_radius(self) -> float:
        """The distance from its path that the base needs while it follows it, m.

        A car does not turn on the spot. On its sharpest arc, a corner of its hull sweeps this far
        outside of the path of its origin.
        """
        sharpest = self.drive.max_curvature
        if math.isinf(sharpest):
            return self.turning_radius
        hull, arc = self.hull, 1.0 / sharpest
        return math.hypot(arc + hull.half_width, max(hull.front, -hull.rear)) - arc

    @property
    def all_lidars(self) -> dict[str, LidarModel]:
        """All lidars by their topics; the first is `lidar`."""
        others = {f"scan_{name}": lidar for name, lidar in self.lidars.items()}
        return {"scan": self.lidar, **others}

    @cached_property
    def sees_behind(self) -> bool:
        """Whether a lidar looks at the ground behind the base."""
        for lidar in self.all_lidars.values():
            first, last = lidar.sector or (0.0, 360.0)
            if (180.0 - lidar.yaw - first) % 360.0 <= last - first:
                return True
        return False

    @cached_property
    def hull(self) -> Hull:
        """The rectangle around body and wheels seen from above."""
        xs, ys = zip(*self.body.corners, strict=True)
        front, rear, side = self.drive.reach
        return Hull(
            round(max(*xs, front), _WHOLE_DIGITS),
            round(min(*xs, rear), _WHOLE_DIGITS),
            round(max(*map(abs, ys), side), _WHOLE_DIGITS),
        )

    @cached_property
    def turning_radius(self) -> float:
        """The circle that the hull sweeps when it turns about the base's origin, m."""
        drive = self.drive
        half = drive.wheel_width / 2
        wheels = (math.hypot(abs(x) + drive.wheel_radius, abs(y) + half) for x, y in drive.places)
        return max(self.body.reach, *wheels)


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
