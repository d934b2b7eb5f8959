"""What can break on a robot while the simulation runs: one record for each part, set at any time.

    robot.faults.set("lidar", noise=0.1, sectors=((-20, 20),))
    robot.faults.set("lidar", dead=True)         # the noise stays set, for when it lives again
    robot.faults.set("wheels", left_blocked=True)
    robot.faults.clear("lidar")
    robot.faults.clear()

A sensor's fault shows from its next measurement on, a wheel's from the next step of the physics.
What is random about one depends on the robot's seed and the number of the measurement alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any

from bt_mission.core.diagnostics import did_you_mean, listed
from bt_mission.core.errors import BtMissionError


class FaultError(BtMissionError):
    """A fault that a robot cannot have."""


def _within(value: object, least: float, most: float, unit: str = "") -> bool:
    del unit  # for the message alone
    return (
        isinstance(value, int | float)
        and not isinstance(value, bool)
        and math.isfinite(value)
        and least <= value <= most
    )


def _are_sectors(value: object) -> bool:
    return isinstance(value, tuple) and all(
        isinstance(pair, tuple)
        and len(pair) == 2
        and all(_within(bearing, -360, 360) for bearing in pair)
        for pair in value
    )


def _number(least: float, most: float, unit: str, default: float = 0.0) -> Any:
    """Return a field with its limits."""
    return field(default=default, metadata={"least": least, "most": most, "unit": unit})


@dataclass(frozen=True, slots=True, kw_only=True)
class PartFaults:
    """What is wrong with one part. Raises FaultError for a value that cannot be."""

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(each.default, bool):
                if not isinstance(value, bool):
                    raise FaultError(f"{each.name}: expected True or False, got {value!r}")
            elif each.metadata and not _within(value, **each.metadata):
                least, most = each.metadata["least"], each.metadata["most"]
                raise FaultError(
                    f"{each.name}: expected {least:g} to {most:g} {each.metadata['unit']},"
                    f" got {value!r}"
                )


@dataclass(frozen=True, slots=True, kw_only=True)
class LidarFaults(PartFaults):
    """A lidar that reads wrong, in part or not at all.

    A direction that is lost reads as where there is nothing: inf with an LDS-01, NaN with an
    LDS-02.
    """

    noise: float = _number(0, 10, "m")
    """1 sigma of normal noise on top of the sensor's own, m."""
    bias: float = _number(-10, 10, "m")
    """Added to every distance, m."""
    sectors: tuple[tuple[float, float], ...] = ()
    """Lost directions, each from a bearing counter-clockwise to another, deg; ahead is 0 and left
    positive: (-20, 20) is what lies ahead, (160, -160) what lies behind, (-180, 180) all."""
    dropout: float = _number(0, 1, "of all rays")
    """Share of the directions that are lost, other ones each time."""
    frozen: bool = False
    """It repeats its last scan, with fresh stamps."""
    dead: bool = False
    """It publishes nothing."""

    def __post_init__(self) -> None:
        # super() without arguments does not know this class once it has slots.
        PartFaults.__post_init__(self)
        if not _are_sectors(self.sectors):
            raise FaultError(
                "sectors: expected ((FROM, TO), ...) in degrees from -360 to 360, left positive,"
                f" got {self.sectors!r}"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class OdometryFaults(PartFaults):
    """Odometry that reckons with wrong figures, or drifts, or is silent."""

    left_radius_error: float = _number(-0.9, 9, "(relative)")
    """How much too large it takes the left wheel to be, relative; both: distances are off."""
    right_radius_error: float = _number(-0.9, 9, "(relative)")
    separation_error: float = _number(-0.9, 9, "(relative)")
    """How much too far apart it takes the wheels to be, relative: turns are off."""
    drift: float = _number(-10, 10, "m/s")
    """It creeps ahead so fast, m/s, whatever the wheels do."""
    turn_drift: float = _number(-360, 360, "deg/s")
    """It turns to the left so fast, deg/s."""
    dead: bool = False
    """`odom` is not published, nor the transforms that come from it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImuFaults(PartFaults):
    """An IMU that is silent."""

    dead: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class JointFaults(PartFaults):
    """Encoders whose `joint_states` are not published; odometry goes on."""

    dead: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraFaults(PartFaults):
    """A camera that shows something else, or nothing."""

    noise: float = _number(0, 1, "of full scale")
    """1 sigma for each channel of each pixel, as a share of full scale."""
    black: bool = False
    frozen: bool = False
    """It repeats its last picture, with fresh stamps."""
    dead: bool = False
    """Neither pictures nor camera_info are published."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelFaults(PartFaults):
    """Wheels that slip, or do not turn."""

    left_grip: float = _number(0, 1, "(1: as it is)", 1.0)
    """Its coefficient of friction on whatever it touches; on a slippery place the lower counts."""
    right_grip: float = _number(0, 1, "(1: as it is)", 1.0)
    left_blocked: bool = False
    right_blocked: bool = False


NO_LIDAR_FAULTS = LidarFaults()
NO_ODOMETRY_FAULTS = OdometryFaults()
NO_CAMERA_FAULTS = CameraFaults()

_NONE: dict[str, PartFaults] = {
    "lidar": NO_LIDAR_FAULTS,
    "odometry": NO_ODOMETRY_FAULTS,
    "imu": ImuFaults(),
    "joints": JointFaults(),
    "camera": NO_CAMERA_FAULTS,
    "wheels": WheelFaults(),
}


class RobotFaultState:
    """The faults that one robot has at present, part by part.

    At the start there are none, but for what :meth:`set_usual` makes usual.

    `on_wheels` is called with every change of the wheels' faults. `lacks` says why parts that
    others have cannot break here.
    """

    def __init__(
        self,
        on_wheels: Callable[[WheelFaults], None],
        lacks: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self._on_wheels = on_wheels
        self.lacks = lacks
        self._usual = dict(_NONE)
        self.lidar = NO_LIDAR_FAULTS
        self.odometry = NO_ODOMETRY_FAULTS
        self.imu = ImuFaults()
        self.joints = JointFaults()
        self.camera = NO_CAMERA_FAULTS
        self.wheels = WheelFaults()

    def set(self, part: str, **changes: Any) -> None:
        """Change faults of a part; what is not named stays as it is.

        Raises FaultError where part, fault or value is not one of its.
        """
        if part in self.lacks:
            raise FaultError(self.lacks[part])
        now = self._of(part)
        known = [each.name for each in fields(now)]
        for name in changes:
            if name not in known:
                raise FaultError(_unknown(f"fault '{name}' of the part '{part}'", name, known))
        try:
            self._put(part, replace(now, **changes))
        except FaultError as error:
            raise FaultError(f"{part}: {error}") from None

    def set_usual(self, part: str, **usual: Any) -> None:
        """Make figures of a part usual: it has them now, and again whenever it is cleared."""
        self._usual[part] = replace(_NONE[part], **usual)
        self._put(part, self._usual[part])

    def clear(self, part: str | None = None) -> None:
        """Make a part as usual, or all. Raises FaultError for an unknown part."""
        for each in _NONE if part is None else (part,):
            self._of(each)
            self._put(each, self._usual[each])

    @property
    def present(self) -> dict[str, PartFaults]:
        """The parts with which something is wrong."""
        return {
            part: now for part, usual in self._usual.items() if (now := self._of(part)) != usual
        }

    def _of(self, part: str) -> PartFaults:
        if part not in _NONE:
            raise FaultError(_unknown(f"part '{part}' that can break", part, list(_NONE)))
        found: PartFaults = getattr(self, part)
        return found

    def _put(self, part: str, faults: PartFaults) -> None:
        # Readers tell by identity that nothing is wrong.
        setattr(self, part, _NONE[part] if faults == _NONE[part] else faults)
        if isinstance(faults, WheelFaults):
            self._on_wheels(faults)


def _unknown(what: str, name: str, known: list[str]) -> str:
    near = did_you_mean(name, known)
    return f"there is no {what} (known: {listed(known)})" + (f"; {near}" if near else "")
