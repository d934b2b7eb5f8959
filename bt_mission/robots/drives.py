"""The kinds of base: the wheels of each, and the motions that they allow.

The origin of a base is the middle of its axle: of the driven one of a differential drive, of the
rear one of a car, of all wheels of the others.
"""

import math
from abc import abstractmethod
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, field_validator

from bt_mission.robots.parts import (
    Length,
    Mass,
    Place,
    Point2,
    Point3,
    RobotPart,
    Size3,
    Speed,
    TurnRate,
    WheelRadius,
)

_SINGULAR = 0.1
"""The least singular value of their matrix; that of three wheels at 120 deg is 1.2."""


class Wheels(RobotPart):
    """The wheels of a base: radius and width, m."""

    wheel_radius: WheelRadius
    wheel_width: Length

    @property
    @abstractmethod
    def places(self) -> tuple[Point2, ...]:
        """The place of each wheel on the floor, m."""

    @property
    def supports(self) -> tuple[Point2, ...]:
        """Where the base stands on the floor, m: first its wheels."""
        return self.places

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """The name of each wheel, in the order of `places`."""

    @property
    def max_curvature(self) -> float:
        """The sharpest arc, 1/m; infinite for a base that turns on the spot."""
        return math.inf

    @property
    def slide_velocity(self) -> float:
        """The fastest motion sideways, m/s; 0 for a base that does not slide."""
        return 0.0

    @property
    def headings(self) -> tuple[float, ...]:
        """The direction in which each wheel rolls, rad from ahead."""
        return (0.0,) * len(self.places)

    @property
    def corners(self) -> tuple[Point2, ...]:
        """The corners of all wheels seen from above, m."""
        sides = [
            (i * self.wheel_radius, j * self.wheel_width / 2) for i in (1, -1) for j in (1, -1)
        ]
        return tuple(
            (
                x + math.cos(h) * along - math.sin(h) * aside,
                y + math.sin(h) * along + math.cos(h) * aside,
            )
            for (x, y), h in zip(self.places, self.headings, strict=True)
            for along, aside in sides
        )


class DifferentialDrive(Wheels):
    """Two driven wheels on one axle, and casters.

    Control and odometry use `wheel_separation`; the real separation is `2 * wheel_y`. Mass, inertia
    and casters are missing where the robot has a `model`.
    """

    kind: Literal["differential"]
    wheel_separation: Length
    wheel_y: Length
    wheel_mass: Mass = 0.0
    wheel_inertia: Size3 = (0.0, 0.0, 0.0)
    caster_radius: Length = 0.0
    casters: Annotated[tuple[Point3, ...], Field(min_length=1)] = ()

    @property
    def places(self) -> tuple[Point2, ...]:
        """The left and the right wheel, m."""
        return (0.0, self.wheel_y), (0.0, -self.wheel_y)

    @property
    def supports(self) -> tuple[Point2, ...]:
        """Wheels and casters, m."""
        return *self.places, *((x, y) for x, y, _ in self.casters)

    @property
    def names(self) -> tuple[str, ...]:
        """The left and the right wheel."""
        return "wheel_left", "wheel_right"


class SkidSteerDrive(Wheels):
    """Two wheels on each side that turn together; the base turns because they skid.

    Control and odometry use `wheel_separation`, which is larger than `2 * wheel_y`: how much
    larger depends on tyres and floor, and is measured.
    """

    kind: Literal["skid_steer"]
    wheel_separation: Length
    wheel_y: Length
    wheelbase: Length

    @property
    def places(self) -> tuple[Point2, ...]:
        """Front left, front right, rear left, rear right, m."""
        return tuple((x * self.wheelbase / 2, y * self.wheel_y) for x in (1, -1) for y in (1, -1))

    @property
    def names(self) -> tuple[str, ...]:
        """Front left, front right, rear left, rear right."""
        return "front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel"


class AckermannDrive(Wheels):
    """A car: two driven wheels on the rear axle, two steered ones in front.

    `max_steering_angle` (rad) is that of a single wheel in the middle of the front axle, and
    `max_steering_velocity` (rad/s) how fast it changes.
    """

    kind: Literal["ackermann"]
    wheel_y: Length
    wheelbase: Length
    max_steering_angle: Annotated[float, Field(gt=0, lt=1.5, allow_inf_nan=False)]
    max_steering_velocity: TurnRate

    @property
    def places(self) -> tuple[Point2, ...]:
        """Front left, front right, rear left, rear right, m."""
        return tuple((x, y * self.wheel_y) for x in (self.wheelbase, 0.0) for y in (1, -1))

    @property
    def names(self) -> tuple[str, ...]:
        """Front left, front right, rear left, rear right."""
        return "front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel"

    @property
    def max_curvature(self) -> float:
        """The sharpest arc of the middle of the rear axle, 1/m."""
        return math.tan(self.max_steering_angle) / self.wheelbase


class OmniWheel(RobotPart):
    """A wheel with rollers: place, m; heading in which it rolls, deg from ahead, left positive.

    `roller`: the angle of its rollers' axes to that direction, deg. 0 are those of an omni wheel,
    which rolls freely sideways; 45 or -45 those of a mecanum wheel.
    """

    x: Place
    y: Place
    heading: Annotated[float, Field(ge=-360, le=360, allow_inf_nan=False)]
    roller: Annotated[float, Field(ge=-80, le=80, allow_inf_nan=False)] = 0.0

    def row(self, radius: float) -> tuple[float, float, float]:
        """Return its rotation per velocity ahead, to the left, and turned to the left, rad/m."""
        heading, roller = math.radians(self.heading), math.radians(self.roller)
        scale = 1.0 / (radius * math.cos(roller))
        ahead, left = math.cos(heading + roller), math.sin(heading + roller)
        return scale * ahead, scale * left, scale * (self.x * left - self.y * ahead)


class OmnidirectionalDrive(Wheels):
    """Three or four wheels with rollers: the base also moves sideways. Velocities in m/s."""

    kind: Literal["omnidirectional"]
    max_lateral_velocity: Speed
    wheels: Annotated[tuple[OmniWheel, ...], Field(min_length=3, max_length=4)]

    @field_validator("wheels")
    @classmethod
    def _drive_every_way(cls, wheels: tuple[OmniWheel, ...]) -> tuple[OmniWheel, ...]:
        import numpy as np  # noqa: PLC0415 - for this drive alone

        rows = np.array([wheel.row(1.0) for wheel in wheels])
        largest = max(1e-9, float(np.hypot(*np.array([(w.x, w.y) for w in wheels]).T).max()))
        rows[:, 2] /= largest
        if np.linalg.svd(rows, compute_uv=False)[-1] < _SINGULAR:
            raise ValueError(
                "these wheels cannot drive ahead, sideways and turn independently; check their"
                " places (m), headings and rollers (deg)"
            )
        return wheels

    @property
    def slide_velocity(self) -> float:
        """The fastest motion sideways, m/s."""
        return self.max_lateral_velocity

    @property
    def places(self) -> tuple[Point2, ...]:
        """The wheels in the order of the file, m."""
        return tuple((wheel.x, wheel.y) for wheel in self.wheels)

    @property
    def names(self) -> tuple[str, ...]:
        """The wheels, numbered in the order of the file."""
        return tuple(f"wheel_{number}" for number in range(1, len(self.wheels) + 1))

    @property
    def headings(self) -> tuple[float, ...]:
        """The direction in which each wheel rolls, rad from ahead."""
        return tuple(math.radians(wheel.heading) for wheel in self.wheels)


Drive: TypeAlias = Annotated[
    DifferentialDrive | SkidSteerDrive | AckermannDrive | OmnidirectionalDrive,
    Field(discriminator="kind"),
]
