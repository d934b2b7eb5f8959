"""What changes in the world: obstacles that appear, move and vanish, and are on no map.

A place is ``ahead`` and ``left`` of the robot as it stands then (m, from the middle of the axle to
the middle of the obstacle), or ``at`` x and y of the map.
"""

from __future__ import annotations

import math
from itertools import count
from typing import Any

from bt_mission.scenarios.faults.effects import mistakes_of_test
from bt_mission.scenarios.faults.errors import ScenarioError, no_such
from bt_mission.scenarios.faults.fault import Fault, FaultInstance
from bt_mission.scenarios.faults.kind import Arguments, FaultKind
from bt_mission.scenarios.faults.parameters import ABOVE_0, Drawn, Parameter, Range, always, steps

MOST_OBSTACLES = 4
"""Obstacles that can appear in a run by default; they cost a few per cent."""

OBSTACLES = ("spawn_box", "spawn_cylinder")
"""The faults that have an obstacle appear."""

OF_A_BOX = ("move_box", "remove_box")
"""Faults of an obstacle that another fault has spawned."""

OF_THE_WORLD = (*OBSTACLES, *OF_A_BOX)
"""The faults of the world, which all robots of a fleet share."""

BOX = (0.2, 0.2, 0.3)
"""Length, width and height, m."""

_NO_PLACE = "give a place, as ahead=1.0 (and left=) or at=(x, y)"


def _spawn(fault: FaultInstance, given: Arguments) -> None:
    x, y, heading = _place(fault, given)
    shape = {
        name: given[name]
        for name in ("size", "radius", "height", "even_into_the_robot", "nearest_free")
        if name in given
    }
    yaw_deg = (given.get("yaw", 0.0) + math.degrees(heading)) % 360
    with mistakes_of_test(fault.fault.what):
        prop = _props(fault).place(_free(fault, given["name"]), x, y, yaw_deg=yaw_deg, **shape)
    fault.made = prop
    fault.undo(prop.remove)


def _move(fault: FaultInstance, given: Arguments) -> None:
    x, y, _ = _place(fault, given)
    if given["nearest_free"]:
        length, width = fault.run.robot_run.robot.physics.world.size
        x = min(max(x, -length / 2), length / 2)
        y = min(max(y, -width / 2), width / 2)
    with mistakes_of_test("move_box"):
        _prop(fault, given["box"]).move_to(x, y, given["speed"])


def _remove(fault: FaultInstance, given: Arguments) -> None:
    prop = _prop(fault, given["box"])
    made = [injected for injected in fault.run.faults if injected.made is prop]
    if not made:
        raise ScenarioError("remove_box: the obstacle belongs to a fault of another robot")
    for injected in made:
        injected.end()


def _place(fault: FaultInstance, given: Arguments) -> tuple[float, float, float]:
    """Return a place in the map, m, and the direction that it counts yaw from, rad."""
    ahead, left, at = given["ahead"], given["left"], given["at"]
    if at is not None:
        return (*at, 0.0)
    if ahead is None:
        raise ScenarioError(f"{fault.fault.what}: {_NO_PLACE}")
    x, y, yaw = fault.run.robot_run.robot.pose
    cos, sin = math.cos(yaw), math.sin(yaw)
    return x + ahead * cos - left * sin, y + ahead * sin + left * cos, yaw


def _props(fault: FaultInstance) -> Any:
    return fault.run.robot_run.robot.physics.props


def _free(fault: FaultInstance, name: str) -> str:
    taken = {prop.name for prop in _props(fault)}
    if name not in taken:
        return name
    return next(other for n in count(2) if (other := f"{name} {n}") not in taken)


def _prop(fault: FaultInstance, box: Fault | str) -> Any:
    """Return the obstacle of a name, or that a fault has made."""
    there = list(_props(fault))
    if isinstance(box, Fault):
        made = [
            injected.made
            for injected in fault.run.faults
            if injected.fault is box and injected.made in there
        ]
        if not made:
            raise ScenarioError(f"{box!r} has no obstacle in the world now")
        return made[-1]
    named = [spawned for spawned in there if spawned.name == box]
    if not named:
        raise no_such("spawned obstacle", box, [spawned.name for spawned in there])
    return named[0]


# ---- rows --------------------------------------------------------------------------------------


def _where(ahead: Drawn, left: Drawn) -> tuple[Parameter, ...]:
    return (
        Parameter("ahead", "number", default=None, unit="m", drawn=ahead),
        Parameter("left", "number", default=0.0, unit="m", drawn=left),
        Parameter("at", "numbers", default=None, unit="m", count=2, by_name=True),
    )


def _size(name: str, default: float) -> Parameter:
    return Parameter(name, "number", "", default, unit="m", allowed=ABOVE_0, by_name=True)


def _nearest(text: str) -> Parameter:
    return Parameter("nearest_free", "flag", text, False, by_name=True, drawn=always(True))


INTO = Parameter("even_into_the_robot", "flag", default=False, by_name=True)
NEAREST = _nearest("If there is no room, at the nearest free place.")
AHEAD = _where(steps(0.4, 2, 0.2), steps(-0.6, 0.6, 0.2))


def _appears(name: str, text: str, usual: str, *shape: Parameter) -> FaultKind:
    named = Parameter(
        "name",
        "text",
        "Used in collisions and by `move_box`; made unique by a number.",
        usual,
        by_name=True,
    )
    declared = (*AHEAD, named, *shape, INTO, NEAREST)

    def check(given: Arguments) -> str:
        return _NO_PLACE if (given["ahead"] is None) == (given["at"] is None) else ""

    return FaultKind(name, text, _spawn, declared, "Obstacles", check=check)


BOX_PARAMETER = Parameter(
    "box", "text", "Its name; in Python also the fault that created it.", "box", takes=Fault
)

ROWS = (
    _appears(
        "spawn_box",
        "A box appears until the end of the fault.",
        "box",
        Parameter(
            "yaw",
            "number",
            "From the robot's heading; with `at`, from the map's x.",
            0.0,
            unit="deg",
            by_name=True,
        ),
        Parameter(
            "size",
            "numbers",
            "Length, width and height.",
            BOX,
            unit="m",
            allowed=ABOVE_0,
            count=3,
            by_name=True,
            is_quiet=True,
        ),
    ),
    _appears(
        "spawn_cylinder",
        "A cylinder appears until the end of the fault.",
        "cylinder",
        _size("radius", 0.1),
        _size("height", 0.5),
    ),
    FaultKind(
        "move_box",
        "An obstacle moves straight to a place, and pushes what is in its path.",
        _move,
        (
            BOX_PARAMETER,
            *_where(steps(-0.5, 1.5, 0.5), steps(-1, 1, 0.5)),
            Parameter(
                "speed",
                "number",
                default=0.5,
                unit="m/s",
                allowed=Range(0, 2, is_open=True),
                by_name=True,
                drawn=steps(0.1, 1, 0.1),
            ),
            _nearest("To the nearest place of the floor, if the place is outside."),
        ),
        "Obstacles",
        lasts=False,
    ),
    FaultKind(
        "remove_box", "An obstacle vanishes.", _remove, (BOX_PARAMETER,), "Obstacles", lasts=False
    ),
)
