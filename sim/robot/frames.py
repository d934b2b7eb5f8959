"""The robot's frames as its URDF has them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bt_mission.robots.drives import DifferentialDrive, OmnidirectionalDrive
from bt_mission.robots.model import RobotModel
from sim.frames import BASE_FOOTPRINT, BASE_LINK, FramePose, Quaternion, Vector
from sim.sensors.kinds import sensors_of

# A quarter turn about x to the right: z along the axle to the left.
_SIDEWAYS: Quaternion = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))


def fixed_frames(robot: RobotModel) -> list[FramePose]:
    """Return all frames below `base_footprint`. Wheels are shown as at the start."""
    drive = robot.drive
    axle_z = drive.wheel_radius - robot.base_height
    casters = drive.casters if isinstance(drive, DifferentialDrive) else ()
    names = _caster_names(casters)
    return [
        FramePose(BASE_FOOTPRINT, BASE_LINK, (0.0, 0.0, robot.base_height)),
        *(
            FramePose(BASE_LINK, f"{name}_link", (x, y, axle_z), _axle(robot, index))
            for index, (name, (x, y)) in enumerate(zip(drive.names, drive.places, strict=True))
        ),
        *(
            FramePose(BASE_LINK, name, at, _SIDEWAYS)
            for name, at in zip(names, casters, strict=True)
        ),
        *(frame for kind in sensors_of(robot) for frame in kind.frames(robot)),
    ]


def _axle(robot: RobotModel, index: int) -> Quaternion:
    """Return the rotation of a wheel's frame: z along its axle to the left of its heading."""
    if not isinstance(robot.drive, OmnidirectionalDrive):
        return _SIDEWAYS
    half = math.radians(robot.drive.wheels[index].heading) / 2
    x, _, _, w = _SIDEWAYS
    return math.cos(half) * x, math.sin(half) * x, math.sin(half) * w, math.cos(half) * w


def _caster_names(casters: Sequence[Vector]) -> list[str]:
    """Return the frame of each caster; those on the same side are numbered."""
    places = []
    for x, y, _ in casters:
        end = "_front" if x > 0 else "_back" if x < 0 else ""
        places.append(f"caster{end}{'_left' if y > 0 else '_right' if y < 0 else ''}")
    return [
        f"{place}_{places[:index].count(place) + 1}_link"
        if places.count(place) > 1
        else f"{place}_link"
        for index, place in enumerate(places)
    ]
