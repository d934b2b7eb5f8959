"""The shortest curves of a car that also drives back, between two poses without obstacles.

J. A. Reeds and L. A. Shepp, "Optimal paths for a car that goes both forwards and backwards" (1990):
at most five pieces, each straight or on the sharpest arc. The formulas are those of section 8 of
the paper, for a sharpest arc of radius 1; mirroring and reversing them gives the other curves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TypeAlias

from bt_mission.base.geometry import Pose2D

Pieces: TypeAlias = tuple[tuple[int, float], ...]
"""Side of the arc (1 left, 0 straight, -1 right), and its length, negative if it is driven back."""

_Lengths: TypeAlias = tuple[float, ...] | None
_Formula: TypeAlias = Callable[[float, float, float], _Lengths]

_QUARTER = math.pi / 2.0
_SLACK = 1e-9


def curves(start: Pose2D, goal: Pose2D, curvature: float) -> list[Pieces]:
    """Return the curves from one pose to another, shortest first; lengths in metres."""
    across, along = goal.x - start.x, goal.y - start.y
    cosine, sine = math.cos(start.yaw), math.sin(start.yaw)
    x = (cosine * across + sine * along) * curvature
    y = (cosine * along - sine * across) * curvature
    turn = goal.yaw - start.yaw
    scaled = (
        tuple((side, length / curvature) for side, length in pieces if abs(length) > _SLACK)
        for pieces in _all(x, y, turn)
    )
    return sorted(scaled, key=lambda pieces: sum(abs(length) for _, length in pieces))


def _all(x: float, y: float, turn: float) -> Iterator[Pieces]:
    """Yield the curves of each family: as it is, driven back, mirrored, and both."""
    for formula, sides, is_reversible in _FAMILIES:
        for back in (1, -1):
            for mirror in (1, -1):
                place = back * x, mirror * y, back * mirror * turn
                lengths = formula(*place)
                if lengths is not None:
                    yield _pieces(sides, lengths, mirror, back)
                if not is_reversible:
                    continue
                # The same from the goal to the start, whose pieces are in the opposite order.
                x_from, y_from, turned = place
                cosine, sine = math.cos(turned), math.sin(turned)
                lengths = formula(
                    x_from * cosine + y_from * sine, x_from * sine - y_from * cosine, turned
                )
                if lengths is not None:
                    yield _pieces(sides[::-1], lengths[::-1], mirror, back)


def _pieces(sides: tuple[int, ...], lengths: tuple[float, ...], mirror: int, back: int) -> Pieces:
    return tuple(
        (mirror * side, back * length) for side, length in zip(sides, lengths, strict=True)
    )


def _wrap(angle: float) -> float:
    return math.remainder(angle, math.tau)


def _polar(x: float, y: float) -> tuple[float, float]:
    return math.hypot(x, y), math.atan2(y, x)


def _same_side(x: float, y: float, turn: float) -> _Lengths:
    """L+ S+ L+."""
    straight, first = _polar(x - math.sin(turn), y - 1.0 + math.cos(turn))
    last = _wrap(turn - first)
    return (first, straight, last) if first >= -_SLACK and last >= -_SLACK else None


def _other_side(x: float, y: float, turn: float) -> _Lengths:
    """L+ S+ R+."""
    far, angle = _polar(x + math.sin(turn), y - 1.0 - math.cos(turn))
    if far < 2.0:
        return None
    straight = math.sqrt(far * far - 4.0)
    first = _wrap(angle + math.atan2(2.0, straight))
    last = _wrap(first - turn)
    return (first, straight, last) if first >= -_SLACK and last >= -_SLACK else None


def _three_arcs(x: float, y: float, turn: float) -> _Lengths:
    """L+ R- L."""
    far, angle = _polar(x - math.sin(turn), y - 1.0 + math.cos(turn))
    if far > 4.0:
        return None
    middle = -2.0 * math.asin(far / 4.0)
    first = _wrap(angle + middle / 2.0 + math.pi)
    last = _wrap(turn - first + middle)
    return (first, middle, last) if first >= -_SLACK and middle <= _SLACK else None


def _ends(u: float, v: float, xi: float, eta: float, turn: float) -> tuple[float, float]:
    delta = _wrap(u - v)
    a = math.sin(u) - math.sin(delta)
    b = math.cos(u) - math.cos(delta) - 1.0
    angle = math.atan2(eta * a - xi * b, xi * a + eta * b)
    which = 2.0 * (math.cos(delta) - math.cos(v) - math.cos(u)) + 3.0
    first = _wrap(angle + math.pi) if which < 0.0 else _wrap(angle)
    return first, _wrap(first - u + v - turn)


def _four_arcs_one_cusp(x: float, y: float, turn: float) -> _Lengths:
    """L+ R+ L- R-."""
    xi, eta = x + math.sin(turn), y - 1.0 - math.cos(turn)
    share = 0.25 * (2.0 + math.hypot(xi, eta))
    if share > 1.0:
        return None
    middle = math.acos(share)
    first, last = _ends(middle, -middle, xi, eta, turn)
    ends = first >= -_SLACK and last <= _SLACK
    return (first, middle, -middle, last) if ends else None


def _four_arcs_two_cusps(x: float, y: float, turn: float) -> _Lengths:
    """L+ R- L- R+."""
    xi, eta = x + math.sin(turn), y - 1.0 - math.cos(turn)
    share = (20.0 - xi * xi - eta * eta) / 16.0
    if not 0.0 <= share <= 1.0:
        return None
    middle = -math.acos(share)
    first, last = _ends(middle, middle, xi, eta, turn)
    ends = first >= -_SLACK and last >= -_SLACK
    return (first, middle, middle, last) if ends else None


def _quarter_same(x: float, y: float, turn: float) -> _Lengths:
    """L+ R- (a quarter) S- L-."""
    far, angle = _polar(x - math.sin(turn), y - 1.0 + math.cos(turn))
    if far < 2.0:
        return None
    reach = math.sqrt(far * far - 4.0)
    straight = 2.0 - reach
    first = _wrap(angle + math.atan2(reach, -2.0))
    last = _wrap(turn - _QUARTER - first)
    ends = first >= -_SLACK and straight <= _SLACK and last <= _SLACK
    return (first, -_QUARTER, straight, last) if ends else None


def _quarter_other(x: float, y: float, turn: float) -> _Lengths:
    """L+ R- (a quarter) S- R-."""
    xi, eta = x + math.sin(turn), y - 1.0 - math.cos(turn)
    far, first = _polar(-eta, xi)
    if far < 2.0:
        return None
    straight = 2.0 - far
    last = _wrap(first + _QUARTER - turn)
    ends = first >= -_SLACK and straight <= _SLACK and last <= _SLACK
    return (first, -_QUARTER, straight, last) if ends else None


def _two_quarters(x: float, y: float, turn: float) -> _Lengths:
    """L+ R- (a quarter) S- L- (a quarter) R+."""
    xi, eta = x + math.sin(turn), y - 1.0 - math.cos(turn)
    far = math.hypot(xi, eta)
    if far < 2.0:
        return None
    straight = 4.0 - math.sqrt(far * far - 4.0)
    if straight > _SLACK:
        return None
    along = (4.0 - straight) * xi - 2.0 * eta
    first = _wrap(math.atan2(along, -2.0 * xi + (straight - 4.0) * eta))
    last = _wrap(first - turn)
    ends = first >= -_SLACK and last >= -_SLACK
    return (first, -_QUARTER, straight, -_QUARTER, last) if ends else None


_FAMILIES: tuple[tuple[_Formula, tuple[int, ...], bool], ...] = (
    (_same_side, (1, 0, 1), False),
    (_other_side, (1, 0, -1), False),
    (_three_arcs, (1, -1, 1), True),
    (_four_arcs_one_cusp, (1, -1, 1, -1), False),
    (_four_arcs_two_cusps, (1, -1, 1, -1), False),
    (_quarter_same, (1, -1, 0, 1), True),
    (_quarter_other, (1, -1, 0, -1), True),
    (_two_quarters, (1, -1, 0, 1, -1), False),
)
"""Each with its sides, and whether it also is driven from its end."""
