"""Faults of the robot itself: sensors, wheels, motors, and what pushes it.

A sensor's fault shows from its next measurement on, a wheel's from the next step of the physics.
Of two faults that set the same figure, the later counts; when it ends, the other counts again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from bt_mission.base.units import UNITS
from bt_mission.scenarios.draws import Draws, maybe, number
from bt_mission.scenarios.faults.drawable import Drawable
from bt_mission.scenarios.faults.effects import mistakes_of_test
from bt_mission.scenarios.faults.fault import FaultInstance
from bt_mission.scenarios.faults.kind import Arguments, Effect, FaultKind
from bt_mission.scenarios.faults.parameters import ABOVE_0, Parameter, Range, any_of, seconds, steps
from bt_mission.scenarios.faults.world import OBSTACLES, OF_A_BOX
from sim.faults import PartFaults, WheelFaults
from sim.sensors.camera import CameraFaults
from sim.sensors.lidar import LidarFaults
from sim.sensors.odometry import OdometryFaults

SECTORS = "sectors"
SIDES = {"left": ("left",), "right": ("right",), "both": ("left", "right")}


ON_BODIES = frozenset(("push", "shove", "slip_wheel", "block_wheel", *OBSTACLES, *OF_A_BOX))
"""Faults that act on bodies: another simulator in place of MuJoCo refuses them."""


@dataclass(frozen=True, eq=False)
class Breakage:
    """The changes of a part by a fault."""

    part: str
    changes: Mapping[str, Any]


def _breaks(part: str, changes_of: Callable[[Arguments], Mapping[str, Any]]) -> Effect:
    """Return the effect that breaks a part; where it ends, other faults of the part count again."""

    def effect(fault: FaultInstance, given: Arguments) -> None:
        faults = _robot(fault).faults
        fault.made = made = Breakage(part, changes_of(given))
        with mistakes_of_test(fault.fault.what):
            faults.set(part, **made.changes)

        def repair() -> None:
            faults.clear(part)
            for other in (
                injected.made for injected in fault.run.faults if injected.ended_ns is None
            ):
                if isinstance(other, Breakage) and other.part == part and other is not made:
                    faults.set(part, **other.changes)

        fault.undo(repair)

    return effect


def _at_once(act: Callable[[Any, Arguments], None]) -> Effect:
    """Return the effect of what happens to the robot once."""

    def effect(fault: FaultInstance, given: Arguments) -> None:
        with mistakes_of_test(fault.fault.what):
            act(_robot(fault), given)

    return effect


def _motors_off(fault: FaultInstance, _: Arguments) -> None:
    robot = _robot(fault)
    robot.power_motors(on=False)
    fault.undo(lambda: robot.power_motors(on=True))


def _robot(fault: FaultInstance) -> Any:
    return fault.run.robot_run.robot


def _per_side(figure: str, value: Callable[[Arguments], Any]) -> Callable[[Arguments], Any]:
    """Return what sets a figure of each wheel that is named."""
    return lambda given: {f"{side}_{figure}": value(given) for side in SIDES[given["wheel"]]}


def _any_of(names: Iterable[str], message: str) -> Callable[[Arguments], str]:
    """Return the check that at least one of some arguments is given."""
    return lambda given: "" if any(given[name] for name in names) else message


def _drawn_sectors(draws: Draws, _: Drawable) -> Arguments:
    if maybe(draws, 2):
        middle, half = number(draws, -180, 180, 15), number(draws, 5, 90, 5)
        return {SECTORS: ((middle - half, middle + half),)}
    return {"share": number(draws, 0.1, 1, 0.1)}


# ---- rows --------------------------------------------------------------------------------------


def _figure(
    name: str, of: type[PartFaults], figure: str, text: str = "", **options: Any
) -> Parameter:
    """Return the parameter that sets a figure of a part, with its unit and limits."""
    field = of.model_fields[figure]
    limits = {
        name: getattr(metadata, name)
        for metadata in field.metadata
        for name in ("ge", "le")
        if hasattr(metadata, name)
    }
    unit = (field.description or "").rpartition(" ")[2]
    unit = unit if unit in UNITS else ""
    within = Range(limits["ge"], limits["le"])
    return Parameter(name, "number", text, **{"unit": unit, "allowed": within, **options})


def _part(
    name: str,
    text: str,
    changes: Mapping[str, Any] | Callable[[Arguments], Mapping[str, Any]],
    *declared: Parameter,
    **options: Any,
) -> FaultKind:
    """Return a fault of the part that its name begins with; a text in `changes` is an argument."""
    part = name.partition("_")[0]
    group = "camera" if part == "camera" else "hardware"

    def changes_of(given: Arguments) -> Mapping[str, Any]:
        if callable(changes):
            return changes(given)
        return {
            figure: given[value] if isinstance(value, str) else value
            for figure, value in changes.items()
        }

    effect = _breaks(part, changes_of)
    return FaultKind(name, text, effect, declared, "The robot", group, part=part, **options)


def _robot_fault(
    name: str, text: str, effect: Effect, *declared: Parameter, **options: Any
) -> FaultKind:
    return FaultKind(name, text, effect, declared, "The robot", **{"group": "hardware", **options})


def _speed(name: str, unit: str, drawn: Any, **options: Any) -> Parameter:
    return Parameter(name, "number", default=0.0, unit=unit, drawn=drawn, **options)


ERRORS = ("left_radius", "right_radius", "separation")
WHEEL = Parameter("wheel", "text", choices=tuple(SIDES), drawn=any_of(*SIDES))
BEARING = Range(-360, 360)

ROWS = (
    _part(
        "lidar_noise",
        "Ranges have additional normal noise (1 sigma).",
        {"noise": "sigma"},
        _figure("sigma", LidarFaults, "noise", drawn=steps(0.01, 0.2, 0.01)),
    ),
    _part(
        "lidar_bias",
        "All ranges are too long by this; below 0, too short.",
        {"bias": "metres"},
        _figure("metres", LidarFaults, "bias", drawn=steps(-0.3, 0.3, 0.1)),
    ),
    _part(
        "lidar_blind",
        "Rays of sectors, or a share of all rays, have no return.",
        lambda given: {
            **({SECTORS: given[SECTORS]} if given[SECTORS] else {}),
            **({"dropout": given["share"]} if given["share"] else {}),
        },
        Parameter(
            SECTORS,
            "numbers",
            "Bearings, counter-clockwise, left positive: (-20, 20) is ahead, (160, -160) behind.",
            unit="deg",
            allowed=BEARING,
            count=2,
            repeats=True,
        ),
        _figure("share", LidarFaults, "dropout", "Drawn for each scan.", default=0.0, by_name=True),
        check=_any_of((SECTORS, "share"), "give sectors, such as (-20, 20), or a share"),
        draw=_drawn_sectors,
    ),
    _part("lidar_frozen", "The last scan is repeated with fresh stamps.", {"frozen": True}),
    _part("lidar_dead", "No scans are published.", {"dead": True}),
    _part(
        "odometry_error",
        "Odometry uses wrong parameters: 0.1 is a tenth too large.",
        lambda given: {f"{name}_error": given[name] for name in ERRORS if given[name]},
        *(
            _figure(
                name,
                OdometryFaults,
                f"{name}_error",
                default=0.0,
                by_name=True,
                drawn=steps(-0.2, 0.2, 0.05, instead_of_0=0.05) if name == ERRORS[0] else None,
            )
            for name in ERRORS
        ),
        check=_any_of(ERRORS, "give left_radius, right_radius or separation"),
    ),
    _part(
        "odometry_drift",
        "Odometry adds a motion, ahead and to the left.",
        {"drift": "ahead", "turn_drift": "turn"},
        _figure("ahead", OdometryFaults, "drift", default=0.0, drawn=steps(-0.1, 0.1, 0.05)),
        _figure(
            "turn", OdometryFaults, "turn_drift", default=0.0, by_name=True, drawn=steps(-20, 20, 5)
        ),
    ),
    _part("odometry_dead", "Neither odometry nor its transforms are published.", {"dead": True}),
    _part("imu_dead", "No IMU messages are published.", {"dead": True}),
    _part("joints_dead", "No joint states are published; odometry continues.", {"dead": True}),
    _part(
        "camera_noise",
        "Pixels have normal noise; 1 sigma is a share of full scale.",
        {"noise": "sigma"},
        _figure("sigma", CameraFaults, "noise", drawn=steps(0.1, 0.5, 0.1)),
    ),
    _part("camera_black", "Images are black.", {"black": True}),
    _part("camera_frozen", "The last image is repeated with fresh stamps.", {"frozen": True}),
    _part("camera_dead", "No images are published.", {"dead": True}),
    _robot_fault(
        "slip_wheel",
        "Wheels slip.",
        _breaks("wheels", _per_side("grip", lambda given: given["grip"])),
        WHEEL,
        _figure("grip", WheelFaults, "left_grip", "Their coefficient of friction.", default=0.05),
        part="wheels",
    ),
    _robot_fault(
        "block_wheel",
        "Wheels do not turn.",
        _breaks("wheels", _per_side("blocked", lambda _: True)),
        WHEEL,
        part="wheels",
    ),
    _robot_fault("motors_off", "The motors have no power; the base rolls to rest.", _motors_off),
    _robot_fault(
        "battery_charge",
        "The battery has this charge, 0 to 1. Empty, the motors lose power.",
        _at_once(lambda robot, given: robot.charge_battery(given["share"])),
        Parameter("share", "number", allowed=Range(0, 1), drawn=steps(0, 1, 0.1)),
        group="battery",
        lasts=False,
    ),
    _robot_fault(
        "push",
        "A force pushes the base at its centre of mass; up to 6 N it stands.",
        _at_once(
            lambda robot, given: robot.push(
                (given["ahead"], given["left"]), given["seconds"], torque=given["torque"]
            )
        ),
        _speed("ahead", "N", steps(-20, 20, 5)),
        _speed("left", "N", steps(-20, 20, 5)),
        seconds("seconds", "For how long.", default=0.2, by_name=True, allowed=ABOVE_0),
        _speed("torque", "Nm", None, by_name=True, text="Turns it to the left."),
        lasts=False,
    ),
    _robot_fault(
        "shove",
        "The base has a velocity at once, ahead and to the left, and a turn rate to the left.",
        _at_once(
            lambda robot, given: robot.shove((given["ahead"], given["left"]), turn=given["turn"])
        ),
        _speed("ahead", "m/s", steps(-0.3, 0.3, 0.1)),
        _speed("left", "m/s", steps(-0.3, 0.3, 0.1)),
        _speed("turn", "rad/s", steps(-2, 2, 0.5), by_name=True),
        lasts=False,
    ),
)
