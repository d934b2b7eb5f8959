"""What changes in the world: obstacles that appear, move and vanish."""

from __future__ import annotations

import math
from itertools import count
from typing import Any

from bt_mission.faults.errors import ScenarioError, no_such
from bt_mission.faults.fault import Begin, Fault, FaultInstance
from bt_mission.faults.maker import Maker, makes_fault, mistakes_of_test
from bt_mission.faults.parameters import Degrees, Metres, MetresPerSecond, Place, Seconds

Whereabouts = tuple[float | None, float, tuple[float, float] | None]
"""Ahead and left of the robot, or at a place of the map, m."""

MOST_OBSTACLES = 4
"""Obstacles that can appear in a run, unless it is told otherwise; they cost a few per cent."""

OBSTACLES = ("spawn_box", "spawn_cylinder")
"""The faults that have an obstacle appear."""

OF_THE_WORLD = (*OBSTACLES, "move_box", "remove_box")
"""The faults of the world, which all robots of a fleet share."""

BOX = (0.2, 0.2, 0.3)
"""Length, width and height, m."""


class WorldFaults(Maker):
    """Obstacles that are on no map. At most four at a time, or ``stage.run(..., props=8)``.

    A place is ``ahead`` and ``left`` of the robot as it stands then (m from the axle's middle to
    the obstacle's), or ``at`` x and y of the map.
    """

    @makes_fault
    def spawn_box(  # noqa: PLR0913 - keywords
        self,
        ahead: Metres | None = None,
        left: Metres = 0.0,
        *,
        at: Place | None = None,
        name: str = "box",
        yaw: Degrees = 0.0,
        size: tuple[Metres, Metres, Metres] = BOX,
        even_into_the_robot: bool = False,
        nearest_free: bool = False,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Have a box appear; it vanishes when the fault ends.

        Args:
            yaw: Deg, from the robot's heading, or ``at`` a place, from the map's x.
            size: Length, width and height, m.
            name: In collisions, and for ``move_box``; a number is added where it is taken.
            nearest_free: Where there is no room, at the nearest place that has some.
        """
        shape = {
            "size": size,
            "yaw_deg": yaw,
            "even_into_the_robot": even_into_the_robot,
            "nearest_free": nearest_free,
        }
        return _spawn("spawn_box", (ahead, left, at), shape, name)

    @makes_fault
    def spawn_cylinder(  # noqa: PLR0913 - keywords
        self,
        ahead: Metres | None = None,
        left: Metres = 0.0,
        *,
        at: Place | None = None,
        name: str = "cylinder",
        radius: Metres = 0.1,
        height: Metres = 0.5,
        even_into_the_robot: bool = False,
        nearest_free: bool = False,
        lasting: Seconds | None = None,
    ) -> Begin:
        """Have a cylinder appear; it vanishes when the fault ends.

        Args:
            nearest_free: Where there is no room, at the nearest place that has some.
        """
        shape = {
            "radius": radius,
            "height": height,
            "even_into_the_robot": even_into_the_robot,
            "nearest_free": nearest_free,
        }
        return _spawn("spawn_cylinder", (ahead, left, at), shape, name)

    @makes_fault
    def move_box(
        self,
        box: Fault | str = "box",
        ahead: Metres | None = None,
        left: Metres = 0.0,
        *,
        at: Place | None = None,
        speed: MetresPerSecond = 0.5,
        nearest_free: bool = False,
    ) -> Begin:
        """Have an obstacle go somewhere, straight, whatever stands in its way.

        Args:
            box: What made it appear, or its name.
            speed: M/s, at most 2.
            nearest_free: To the nearest place of the floor, where the place lies outside of it.
        """

        def begin(fault: FaultInstance) -> None:
            x, y, _ = _place(fault, (ahead, left, at))
            if nearest_free:
                length, width = fault.run.robot_run.robot.physics.world.size
                x = min(max(x, -length / 2), length / 2)
                y = min(max(y, -width / 2), width / 2)
            with mistakes_of_test("move_box"):
                _prop(fault, box).move_to(x, y, speed)

        return begin

    @makes_fault
    def remove_box(self, box: Fault | str = "box") -> Begin:
        """Have an obstacle vanish."""

        def begin(fault: FaultInstance) -> None:
            prop = _prop(fault, box)
            made = [one for one in fault.run.faults if one.made is prop]
            if not made:
                raise ScenarioError("remove_box: the obstacle is that of a fault of another robot")
            for one in made:
                one.end()

        return begin


def _spawn(what: str, place: Whereabouts, shape: dict[str, Any], name: str) -> Begin:
    """Give what has an obstacle appear, which vanishes at the end."""
    ahead, _, at = place
    if (ahead is None) == (at is None):
        raise ScenarioError(f"{what}: give a place, as ahead=1.0 (and left=) or at=(x, y)")

    def begin(fault: FaultInstance) -> None:
        x, y, heading = _place(fault, place)
        yaw_deg = (shape.get("yaw_deg", 0.0) + math.degrees(heading)) % 360
        with mistakes_of_test(what):
            prop = _props(fault).place(_free(fault, name), x, y, **(shape | {"yaw_deg": yaw_deg}))
        fault.made = prop
        fault.undo(prop.remove)

    return begin


def _place(fault: FaultInstance, place: Whereabouts) -> tuple[float, float, float]:
    """Return a place in the map, m, and the direction that it counts yaw from, rad."""
    ahead, left, at = place
    if at is not None:
        return (*at, 0.0)
    if ahead is None:
        what = fault.fault.what
        raise ScenarioError(f"{what}: give a place, as ahead=1.0 (and left=) or at=(x, y)")
    x, y, yaw = fault.run.robot_run.robot.pose
    cos, sin = math.cos(yaw), math.sin(yaw)
    return x + ahead * cos - left * sin, y + ahead * sin + left * cos, yaw


def _props(fault: FaultInstance) -> Any:
    return fault.run.robot_run.robot.physics.props


def _free(fault: FaultInstance, name: str) -> str:
    taken = {one.name for one in _props(fault)}
    if name not in taken:
        return name
    return next(other for n in count(2) if (other := f"{name} {n}") not in taken)


def _prop(fault: FaultInstance, box: Fault | str) -> Any:
    """The obstacle of a name, or that a fault has made."""
    there = list(_props(fault))
    if isinstance(box, Fault):
        made = [one.made for one in fault.run.faults if one.fault is box and one.made in there]
        if not made:
            raise ScenarioError(f"{box!r} has no obstacle in the world now")
        return made[-1]
    found = [one for one in there if one.name == box]
    if not found:
        raise no_such("obstacle that was spawned", box, [one.name for one in there])
    return found[0]
