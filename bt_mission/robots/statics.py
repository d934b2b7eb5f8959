"""How a base stands on its wheels and casters."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from bt_mission.robots.body import convex, turn
from bt_mission.robots.parts import Point2


def is_carried(supports: Sequence[Point2], at: Point2) -> bool:
    """Return whether a weight is inside of its supports, not on an edge: from above, m."""
    corners = convex(supports)
    sides = zip(corners, (*corners[1:], *corners[:1]), strict=True)
    return len(corners) > 2 and all(turn(start, end, at) > 0 for start, end in sides)


def shares(supports: Sequence[float], at: float) -> list[float]:
    """Return the share of a weight between the first and the last support that each carries.

    A beam on equal springs, all along x, m: the forces are in balance and linear in x, and none
    pulls. Computed exactly, so that they are the same on every machine.
    """
    carrying = {index: Fraction(x) for index, x in enumerate(supports)}
    while True:
        middle = sum(carrying.values(), Fraction(0)) / len(carrying)
        arm = Fraction(at) - middle
        spread = sum(((x - middle) ** 2 for x in carrying.values()), Fraction(0))
        forces = {
            index: Fraction(1, len(carrying)) + arm * (x - middle) / spread
            for index, x in carrying.items()
        }
        least = min(forces, key=forces.__getitem__)
        if forces[least] >= 0:
            return [float(forces.get(index, 0)) for index in range(len(supports))]
        del carrying[least]
