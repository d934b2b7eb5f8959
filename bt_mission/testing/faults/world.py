"""What changes in the world: obstacles that appear, move and vanish."""

from __future__ import annotations

import math
from itertools import count
from typing import Any

from bt_mission.core.errors import BtMissionError
from bt_mission.testing.errors import ScenarioError, no_such
from bt_mission.testing.faults.fault import Fault, FaultInstance, Maker

BOX = (0.2, 0.2, 0.3)
"""Length, width and height, m."""


class WorldFaults(Maker):
    """Obstacles that are on no map. At most four at a time, or ``stage.run(..., props=8)``.

    A place is ``ahead`` and ``left`` of the robot as it stands then (m from the axle's middle to
    the obstacle's), or ``at`` x and y of the map.
    """

    def spawn_box(
        self,
        ahead: float | None = None,
        left: float = 0.0,
        *,
        at: tuple[float, float] | None = None,
        yaw: float = 0.0,
        size: tuple[float, float, float] = BOX,
        name: str = "box",
        even_into_the_robot: bool = False,
        lasting: float | None = None,
    ) -> Fault:
        """Have a box appear; it vanishes when the fault ends.

        :param yaw: deg, from the robot's heading, or ``at`` a place, from the map's x.
        :param size: length, width and height, m.
        :param name: in collisions, and for ``move_box``; a number is added where it is taken.
        """
        return self._spawn(
            "spawn_box",
            (ahead, left, at),
            {"size": size, "yaw_deg": yaw, "even_into_the_robot": even_into_the_robot},
            name,
            lasting,
            yaw=yaw or None,
            size=size if size != BOX else None,
            even_into_the_robot=even_into_the_robot or None,
        )

    def spawn_cylinder(
        self,
        ahead: float | None = None,
        left: float = 0.0,
        *,
        at: tuple[float, float] | None = None,
        radius: float = 0.1,
        height: float = 0.5,
        name: str = "cylinder",
        even_into_the_robot: bool = False,
        lasting: float | None = None,
    ) -> Fault:
        """Have a cylinder appear; it vanishes when the fault ends."""
        return self._spawn(
            "spawn_cylinder",
            (ahead, left, at),
            {"radius": radius, "height": height, "even_into_the_robot": even_into_the_robot},
            name,
            lasting,
            radius=radius,
            height=height,
            even_into_the_robot=even_into_the_robot or None,
        )

    def move_box(
        self,
        box: Fault | str = "box",
        ahead: float | None = None,
        left: float = 0.0,
        *,
        at: tuple[float, float] | None = None,
        speed: float = 0.5,
    ) -> Fault:
        """Have an obstacle go somewhere, straight, whatever stands in its way.

        :param box: what made it appear, or its name.
        :param speed: m/s, at most 2.
        """

        def begin(fault: FaultInstance) -> None:
            x, y, _ = _place("move_box", fault, (ahead, left, at))
            try:
                _prop(fault, box).move_to(x, y, speed)
            except BtMissionError as error:
                raise ScenarioError(f"move_box: {error}") from error

        return self._fault(
            "move_box",
            begin,
            box=str(box) if isinstance(box, Fault) else box,
            ahead=ahead,
            left=left or None,
            at=at,
            speed=speed,
        )

    def remove_box(self, box: Fault | str = "box") -> Fault:
        """Have an obstacle vanish."""

        def begin(fault: FaultInstance) -> None:
            prop = _prop(fault, box)
            for one in fault.run.faults:
                if one.made is prop:
                    one.end()

        return self._fault("remove_box", begin, box=str(box) if isinstance(box, Fault) else box)

    # ---- inside --------------------------------------------------------------------------

    def _spawn(
        self,
        what: str,
        place: tuple[float | None, float, tuple[float, float] | None],
        shape: dict[str, Any],
        name: str,
        lasting: float | None,
        **parameters: Any,
    ) -> Fault:
        ahead, left, at = place
        if (ahead is None) == (at is None):
            raise ScenarioError(f"{what}: give a place, as ahead=1.0 (and left=) or at=(x, y)")

        def begin(fault: FaultInstance) -> None:
            x, y, heading = _place(what, fault, place)
            given = dict(shape)
            given["yaw_deg"] = (given.get("yaw_deg", 0.0) + math.degrees(heading)) % 360
            try:
                prop = _props(fault).place(_free(fault, name), x, y, **given)
            except BtMissionError as error:
                raise ScenarioError(f"{what}: {error}") from error
            fault.made = prop
            fault.undo(prop.remove)

        return self._fault(
            what,
            begin,
            lasting,
            ahead=ahead,
            left=left or None,
            at=at,
            name=name,
            **parameters,
        )


def _place(
    what: str, fault: FaultInstance, place: tuple[float | None, float, tuple[float, float] | None]
) -> tuple[float, float, float]:
    """A place in the map, and the direction that it counts yaw from, rad."""
    ahead, left, at = place
    if at is not None:
        return (*at, 0.0)
    if ahead is None:
        raise ScenarioError(f"{what}: give a place, as ahead=1.0 (and left=) or at=(x, y)")
    x, y, yaw = fault.run.stage.sim.simulation.pose
    cos, sin = math.cos(yaw), math.sin(yaw)
    return x + ahead * cos - left * sin, y + ahead * sin + left * cos, yaw


def _props(fault: FaultInstance) -> Any:
    return fault.run.stage.sim.simulation.props


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
