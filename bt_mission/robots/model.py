"""The figures of a robot: limits, body, sensors and battery, in SI units, from one file per model.

`robots/NAME.yaml` holds them, each with its source. Frames follow REP 103: x forward, y left, z up;
positions are those of `base_link`, below the middle of the axle.
"""

import math
from collections.abc import Iterator
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from bt_mission.base import files
from bt_mission.base.diagnostics import InputError, listed
from bt_mission.base.file_kinds import refuse_other_formats
from bt_mission.base.yaml.document import Document, read_source, read_text
from bt_mission.base.yaml.models import validate
from bt_mission.robots.body import Body, Hull, PolygonBody, convex
from bt_mission.robots.drives import DifferentialDrive, Drive
from bt_mission.robots.joints import ArmModel, GripperModel, JointLimits, ModelFile
from bt_mission.robots.parts import (
    Acceleration,
    AccelerationNoise,
    AngularAcceleration,
    ControlRate,
    Distance,
    GyroNoise,
    Mass,
    NotNegative,
    Place,
    Point2,
    Point3,
    Positive,
    RangeNoise,
    Rate,
    RobotPart,
    Size3,
    Speed,
    Timeout,
    TurnRate,
)
from bt_mission.robots.statics import is_carried

_STRIDE_M, _EDGE_STEP_M = 0.1, 0.05
"""How far behind the base it must see, and at which distances, m."""

_WHOLE_DIGITS = 9
"""Decimals of a hull in m: without the error of a sum."""

Error = Annotated[float, Field(ge=-0.5, le=0.5, allow_inf_nan=False)]
Bearing = Annotated[float, Field(ge=-360, le=360, allow_inf_nan=False)]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
SensorKey = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,19}$")]
LidarName = Literal["LDS-01", "LDS-02"]

_FEWEST_RAYS = 8
"""With fewer, a full turn has gaps of more than 45 deg: a place beside the robot is not seen."""

LDS_02_SAMPLES = 2300.0
"""Readings a second of an LDS-02, however fast it turns [ROBOTIS e-manual]."""


class RatedSensor(RobotPart):
    """A sensor with its rate (Hz)."""

    rate: Rate


class MountedSensor(RatedSensor):
    """A sensor at a place (m), with its rate (Hz)."""

    x: Place
    y: Place
    z: Place


def _check_ranges(nearest: float, farthest: float) -> None:
    if nearest >= farthest:
        raise ValueError(f"min_range {nearest} m must be below max_range {farthest} m")


class LidarModel(MountedSensor):
    """A planar lidar: place, ranges (m), rays per scan, rate, noise (1 sigma).

    `yaw` is the bearing of its ray 0, deg. `sector` are the bearings of its first and its last ray
    from there, deg, left positive; without it, it measures a full turn. With `model` LDS-02 the
    number of rays varies around `rays`.
    """

    min_range: NotNegative
    max_range: Distance
    rays: Annotated[int, Field(ge=_FEWEST_RAYS, le=10_000)]
    noise_std: RangeNoise
    model: LidarName = "LDS-01"
    yaw: Annotated[float, Field(ge=-360, le=360, allow_inf_nan=False)] = 0.0
    sector: tuple[Bearing, Bearing] | None = None

    @model_validator(mode="after")
    def _ranges_in_order(self) -> Self:
        _check_ranges(self.min_range, self.max_range)
        return self

    @model_validator(mode="after")
    def _sector_in_order(self) -> Self:
        if self.sector is None:
            return self
        first, last = self.sector
        if not 0 < last - first < 360:
            raise ValueError(
                f"sector must reach from a smaller to a larger bearing, less than a full turn,"
                f" got {first:g} to {last:g} deg; leave it out for a full turn"
            )
        if self.model == "LDS-02":
            raise ValueError("an LDS-02 measures a full turn; leave out 'sector'")
        return self

    @property
    def angles(self) -> tuple[float, float]:
        """The bearing of the first ray in the frame of the lidar, and the step to the next, rad."""
        if self.sector is None:
            return 0.0, math.tau / self.rays
        first, last = self.sector
        return math.radians(first), math.radians(last - first) / (self.rays - 1)

    def looks_at(self, x: float, y: float) -> bool:
        """Return whether a place in the frame of the base, m, is in its sector."""
        if self.sector is None:
            return True
        first, last = self.sector
        bearing = math.degrees(math.atan2(y - self.y, x - self.x))
        return (bearing - self.yaw - first) % 360.0 <= last - first

    def as_model(self, model: LidarName) -> Self:
        """Return a lidar of that model at the same place and rate. Figures: ROBOTIS e-manual."""
        if model == "LDS-01":
            figures = {"min_range": 0.12, "max_range": 3.5, "rays": 360}
        else:
            rays = max(_FEWEST_RAYS, round(LDS_02_SAMPLES / self.rate))
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


class DepthCameraModel(MountedSensor):
    """A depth camera that faces forward: place of its lens, image size, ranges (m), rate.

    `width` and `height` in pixels, `hfov` the horizontal field of view. `noise_std` (m) is that of
    a pixel at 1 m; as with stereo cameras, it grows with the square of the distance.
    """

    width: Annotated[int, Field(ge=16, le=640)]
    height: Annotated[int, Field(ge=16, le=480)]
    hfov: Annotated[float, Field(gt=0, lt=math.pi, allow_inf_nan=False)]
    min_range: NotNegative
    max_range: Distance
    noise_std: RangeNoise = 0.0

    @model_validator(mode="after")
    def _depths_in_order(self) -> Self:
        _check_ranges(self.min_range, self.max_range)
        return self


class RangeSensorModel(MountedSensor):
    """A sensor of one distance: place, ranges (m), rate, noise (1 sigma, m).

    `kind`: a `sonar` and an `infrared` sensor look level, at the bearing `yaw` (deg), across
    `field_of_view` (deg). A `cliff` sensor looks straight down: a floor beyond `max_range` is a
    cliff.
    """

    kind: Literal["sonar", "infrared", "cliff"]
    yaw: Bearing = 0.0
    field_of_view: Annotated[float, Field(gt=0, le=120, allow_inf_nan=False)] = 1.0
    min_range: NotNegative
    max_range: Distance
    noise_std: RangeNoise = 0.0

    @model_validator(mode="after")
    def _distances_in_order(self) -> Self:
        _check_ranges(self.min_range, self.max_range)
        return self

    @property
    def bearing(self) -> float:
        """The bearing at which a cliff sensor is mounted, rad; 0 is ahead."""
        return math.atan2(self.y, self.x)


class BumperModel(RatedSensor):
    """A contact sensor on a part of the hull, and how often it looks (Hz).

    `sector` are the bearings of its ends from the middle of the body, deg, left positive.
    """

    sector: tuple[Bearing, Bearing]

    @field_validator("sector")
    @classmethod
    def _in_order(cls, sector: tuple[float, float]) -> tuple[float, float]:
        first, last = sector
        if not 0 < last - first <= 360:
            raise ValueError(
                "sector must reach from a smaller to a larger bearing, at most a full turn,"
                f" got {first:g} to {last:g} deg"
            )
        return sector

    @property
    def bearing(self) -> float:
        """The bearing of its middle, rad; 0 is ahead."""
        return math.radians(sum(self.sector) / 2)


class ImuModel(MountedSensor):
    """Gyroscope and accelerometer: place, rate, noise (rad/s and m/s^2, 1 sigma)."""

    gyro_noise: GyroNoise
    accel_noise: AccelerationNoise


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
    def _voltages_in_order(self) -> Self:
        if self.empty_voltage >= self.full_voltage:
            raise ValueError(
                f"empty_voltage {self.empty_voltage} V must be below"
                f" full_voltage {self.full_voltage} V"
            )
        if not self.empty_voltage <= self.nominal_voltage <= self.full_voltage:
            raise ValueError(
                f"nominal_voltage {self.nominal_voltage} V must be between empty_voltage"
                f" {self.empty_voltage} V and full_voltage {self.full_voltage} V"
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

    `robots/*.yaml` has the source of every number. `lidars`, `range_sensors` and `bumpers` are
    sensors by their names: a lidar `rear` publishes the topic `scan_rear` in the frame
    `base_scan_rear`, a range sensor `front` the topic `range_front`, a bumper `left` the topic
    `bumper_left`. A robot with a `model` of its own has inertia, wheels' mass and casters there;
    `base_mass` is its whole mass.
    """

    name: Annotated[str, Field(min_length=1)]
    max_linear_velocity: Speed
    max_angular_velocity: TurnRate
    max_linear_acceleration: Acceleration
    max_angular_acceleration: AngularAcceleration
    command_timeout: Timeout = 0.2
    control_rate: ControlRate = 20.0
    drive: Drive
    base_height: NotNegative
    base_mass: Mass
    base_inertia: Size3 = (0.0, 0.0, 0.0)
    base_centre_of_mass: Point3 = (0.0, 0.0, 0.0)
    body: Body
    odometry_rate: Rate = 20.0
    lidar: LidarModel
    lidars: dict[SensorKey, LidarModel] = Field(default_factory=dict)
    camera: CameraModel | None = None
    depth_camera: DepthCameraModel | None = None
    range_sensors: dict[SensorKey, RangeSensorModel] = Field(default_factory=dict)
    bumpers: dict[SensorKey, BumperModel] = Field(default_factory=dict)
    imu: ImuModel
    battery: BatteryModel = BatteryModel()
    sensors: SensorsModel = SensorsModel()
    model: ModelFile | None = None
    arm: ArmModel | None = None
    gripper: GripperModel | None = None

    @property
    def moved_joints(self) -> dict[str, JointLimits]:
        """The joints of arm and gripper, by their names."""
        arm = {} if self.arm is None else self.arm.joints
        gripper = self.gripper
        return {**arm, **({} if gripper is None else dict.fromkeys(gripper.joints, gripper))}

    @field_validator("control_rate")
    @classmethod
    def _commands_in_time(cls, rate: float, info: ValidationInfo) -> float:
        timeout = info.data.get("command_timeout", math.inf)
        if rate * timeout < 1:
            raise ValueError(
                f"the base stops {timeout:g} s after a command (command_timeout), and at"
                f" {rate:g} Hz the next one comes later: it would stop between any two"
            )
        return rate

    @field_validator("range_sensors")
    @classmethod
    def _see_the_floor(
        cls, sensors: dict[str, RangeSensorModel], info: ValidationInfo
    ) -> dict[str, RangeSensorModel]:
        base = info.data.get("base_height", 0.0)
        for name, sensor in sensors.items():
            height = base + sensor.z
            if sensor.kind == "cliff" and not sensor.min_range <= height < sensor.max_range:
                raise ValueError(
                    f"{name}: a cliff sensor {height:g} m above the floor must measure that"
                    f" distance, but measures {sensor.min_range:g} to {sensor.max_range:g} m"
                )
        return sensors

    @property
    def mounted(self) -> dict[tuple[str, ...], MountedSensor]:
        """The sensors with a place, by their keys in the file."""
        sensors: dict[tuple[str, ...], MountedSensor] = {}
        for name, part in self:
            if isinstance(part, MountedSensor):
                sensors[(name,)] = part
            elif isinstance(part, dict):
                sensors |= {
                    (name, key): each
                    for key, each in part.items()
                    if isinstance(each, MountedSensor)
                }
        return sensors

    @property
    def rates(self) -> dict[tuple[str, ...], float]:
        """The rates of odometry and of all sensors, Hz, by their keys in the file."""
        rates: dict[tuple[str, ...], float] = {("odometry_rate",): self.odometry_rate}
        for name, part in self:
            if isinstance(part, RatedSensor):
                rates[name, "rate"] = part.rate
            elif isinstance(part, dict):
                rates |= {(name, each, "rate"): sensor.rate for each, sensor in part.items()}
        return rates

    def with_sensors(self, sensors: SensorsModel) -> Self:
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
        """Whether the lidars look at all of the ground that the base covers when it backs up.

        They must see each point of the rear edge, as wide as the hull, one stride behind it.
        """
        hull = self.hull
        behind = hull.rear - _STRIDE_M
        count = math.ceil(2 * hull.half_width / _EDGE_STEP_M) + 1
        places = (hull.half_width * (2 * n / (count - 1) - 1) for n in range(count))
        return all(
            any(lidar.looks_at(behind, y) for lidar in self.all_lidars.values()) for y in places
        )

    @cached_property
    def hull(self) -> Hull:
        """The rectangle around body and wheels seen from above."""
        xs, ys = zip(*self.body.corners, *self.drive.corners, strict=True)
        return Hull(
            round(max(xs), _WHOLE_DIGITS),
            round(min(xs), _WHOLE_DIGITS),
            round(max(map(abs, ys)), _WHOLE_DIGITS),
        )

    @cached_property
    def outline(self) -> tuple[Point2, ...]:
        """The convex outline around a polygon and the wheels, m; empty for other bodies."""
        if not isinstance(self.body, PolygonBody):
            return ()
        return convex((*self.body.corners, *self.drive.corners))

    @cached_property
    def turning_radius(self) -> float:
        """The circle that the hull sweeps when it turns about the base's origin, m."""
        return max(self.body.reach, *(math.hypot(*corner) for corner in self.drive.corners))


def load_robot(name_or_path: str | Path | Document, near: str | Path | None = None) -> RobotModel:
    """Return the model of a robot, by its name or file, or of its text.

    Raises InputError with every fault and its place.

    `near` is a file beside which a robot of that name is looked for first, such as a mission.
    """
    if isinstance(name_or_path, Document):
        file, robot = name_or_path.file, _robot_in(name_or_path)
    else:
        path = files.find("robots", name_or_path, near)
        refuse_other_formats(path, ("robot",))
        file = str(path)
        robot = _robot_of_text(read_source(path), file)
    if robot.model is not None:
        own_file = Path(file).absolute().parent / robot.model.file
        own = robot.model.model_copy(update={"file": str(own_file)})
        robot = robot.model_copy(update={"model": own})
    return robot.with_sensors(robot.sensors)


@lru_cache(maxsize=16)
def _robot_of_text(text: str, file: str) -> RobotModel:
    """Return the robot in the text of a file; checks ask for the same one several times."""
    return _robot_in(read_text(text, file))


def _robot_in(document: Document) -> RobotModel:
    robot = validate(document, RobotModel)
    wrong = list(_form_problems(robot))
    if wrong:
        raise InputError(document.diagnostic(code, path, text) for code, path, text in wrong)
    return robot


_OF_BODY = (("base_inertia",), ("base_centre_of_mass",))
_OF_WHEELS = tuple(
    ("drive", key) for key in ("wheel_mass", "wheel_inertia", "caster_radius", "casters")
)


def _wheel_problems(drive: Drive, model: ModelFile) -> Iterator[tuple[str, tuple[str, ...], str]]:
    """Yield why the joints of a model are not the wheels of a drive."""
    expected, given = drive.names, len(model.wheels)
    if given != len(expected):
        text = f"expected {len(expected)} joints ({listed(expected)}), got {given}"
        yield "BT-307", ("model", "wheels"), text
    if model.steering is not None and drive.kind != "ackermann":
        text = f"only an ackermann drive is steered, and the drive is {drive.kind}"
        yield "BT-307", ("model", "steering"), text


def _inertia_problems(robot: RobotModel) -> Iterator[tuple[str, tuple[str, ...], str]]:
    """Yield why no base, and no wheel, of this mass and size has this inertia."""
    bottom, top = robot.body.heights
    farthest = math.hypot(2 * robot.turning_radius, max(top, 0.0) - min(bottom, 0.0))
    words = "body and wheels allow", "base_mass"
    yield from _impossible(("base_inertia",), robot.base_inertia, robot.base_mass, farthest, *words)
    drive = robot.drive
    if isinstance(drive, DifferentialDrive):
        farthest = math.hypot(2 * drive.wheel_radius, drive.wheel_width)
        words = "wheel_radius and wheel_width allow", "wheel_mass"
        path = ("drive", "wheel_inertia")
        yield from _impossible(path, drive.wheel_inertia, drive.wheel_mass, farthest, *words)


def _impossible(
    path: tuple[str, ...], inertia: Size3, mass: float, farthest: float, size: str, mass_key: str
) -> Iterator[tuple[str, tuple[str, ...], str]]:
    """Yield why no body of a mass, with two points at most `farthest` m apart, has an inertia."""
    low, middle, high = sorted(inertia)
    if high > (low + middle) * (1 + 1e-6):
        text = f"no body has this inertia: {high:g} is more than {low:g} + {middle:g} kg m^2"
        yield "BT-307", path, text
    most = mass * farthest**2
    if high > most:
        text = (
            f"expected at most {most:.3g} kg m^2, all of {mass:g} kg as far apart as {size}, got"
            f" {high:g} kg m^2; check {path[-1]} and {mass_key}"
        )
        yield "BT-307", path, text


def _balance_problems(robot: RobotModel) -> Iterator[tuple[str, tuple[str, ...], str]]:
    """Yield that a base tips over, instead of standing on its wheels and casters."""
    x, y, _ = robot.base_centre_of_mass
    if not is_carried(robot.drive.supports, (x, y)):
        at = listed([f"({a:g}, {b:g})" for a, b in robot.drive.supports])
        text = (
            f"the robot tips over: its centre of mass, ({x:g}, {y:g}) m seen from above, is not"
            f" inside of what carries it, {at}"
        )
        yield "BT-307", ("base_centre_of_mass",), text


def _place_problems(robot: RobotModel) -> Iterator[tuple[str, tuple[str, ...], str]]:
    """Yield which sensors are below the floor."""
    for key, sensor in robot.mounted.items():
        height = robot.base_height + sensor.z
        if height < 0:
            text = f"the sensor is {-height:g} m below the floor"
            yield "BT-307", (*key, "z"), text


def _form_problems(robot: RobotModel) -> Iterator[tuple[str, tuple[str, ...], str]]:
    """Yield code, key and text of keys that exclude or need each other."""
    is_differential = isinstance(robot.drive, DifferentialDrive)
    for path in (*_OF_BODY, *(_OF_WHEELS if is_differential else ())):
        part = robot if len(path) == 1 else robot.drive
        is_given = path[-1] in part.model_fields_set
        if robot.model is None and not is_given:
            yield "BT-202", path[:-1], f"'{path[-1]}' is missing"
        elif robot.model is not None and is_given:
            yield "BT-307", path, f"the file of `model` has this; leave {path[-1]} out"
    if robot.model is not None:
        yield from _wheel_problems(robot.drive, robot.model)
    else:
        yield from _inertia_problems(robot)
        yield from _balance_problems(robot)
    yield from _place_problems(robot)
    for name in ("arm", "gripper"):
        if robot.model is None and getattr(robot, name) is not None:
            yield "BT-307", (name,), f"{name} needs `model`, which has its joints"
    if robot.arm is not None and robot.gripper is not None:
        for name in sorted(set(robot.arm.joints) & set(robot.gripper.joints)):
            yield "BT-307", ("gripper", "joints"), f"the joint '{name}' also is one of the arm"
