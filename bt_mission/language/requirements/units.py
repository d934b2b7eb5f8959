"""Units of numbers in requirements: lengths, times, angles, and what is made of them."""

from __future__ import annotations

import math
from collections.abc import Mapping

from bt_mission.language.expressions.syntax import (
    Arithmetic,
    Comparison,
    Constant,
    FunctionCall,
    Negation,
    SyntaxNode,
)
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.requirements.signals import SIGNALS, Unit
from bt_mission.language.requirements.syntax import Quantity, SignalValue

METRES, SECONDS, RADIANS = (1, 0, 0), (0, 1, 0), (0, 0, 1)

WRITTEN: Mapping[str, tuple[float, Unit]] = {
    "s": (1.0, SECONDS),
    "ms": (1e-3, SECONDS),
    "min": (60.0, SECONDS),
    "m": (1.0, METRES),
    "cm": (1e-2, METRES),
    "mm": (1e-3, METRES),
    "rad": (1.0, RADIANS),
    "deg": (math.pi / 180, RADIANS),
}
"""Units behind numbers: what one of each is in metres, seconds and radians."""

_KEPT = frozenset(("abs", "round", "floor", "ceil"))
_COMMON = frozenset(("min", "max", "clamp"))


def shown_unit(unit: Unit | None) -> str:
    """Return a unit as people write it: ``m/s``; empty for a number without one."""
    names = ("m", "s", "rad")
    above = [_power(name, power) for name, power in zip(names, unit or (0, 0, 0), strict=True)]
    below = [_power(name, -power) for name, power in zip(names, unit or (0, 0, 0), strict=True)]
    over, under = " ".join(filter(None, above)), " ".join(filter(None, below))
    if not under:
        return over
    return f"{over or '1'}/{under}"


def _power(name: str, power: int) -> str:
    return "" if power < 1 else name if power == 1 else f"{name}^{power}"


def unit_of(node: SyntaxNode) -> Unit | None:
    """Return the unit of a number; None where it is not known, or any unit will do.

    Raises:
        ExpressionError: Where metres are compared with, or added to, seconds, and the like.
    """
    match node:
        case Quantity():
            return node.unit
        case SignalValue():
            return SIGNALS[node.name].unit if node.name in SIGNALS else None
        case Negation() | Arithmetic(symbol="+" | "-" | "%"):
            return _agreed(node, node.parts)
        case Arithmetic(symbol="*" | "/" as symbol, left=left, right=right):
            sign = 1 if symbol == "*" else -1
            first, second = _factor(left), _factor(right)
            if first is None or second is None:
                return None
            m, s, rad = (a + sign * b for a, b in zip(first, second, strict=True))
            return m, s, rad
        case FunctionCall(name=name) if name in _COMMON or name in _KEPT:
            return _agreed(node, node.parts[:1] if name in _KEPT else node.parts)
        case Comparison():
            return _agreed(node, node.parts)
    return None


def _factor(node: SyntaxNode) -> Unit | None:
    """Return the unit of a factor; a bare number has none, rather than any."""
    is_bare = isinstance(node, Constant) and not isinstance(node, Quantity)
    return (0, 0, 0) if is_bare else unit_of(node)


def _agreed(node: SyntaxNode, parts: tuple[SyntaxNode, ...]) -> Unit | None:
    """Return the one unit that all parts have."""
    units = [unit for part in parts if (unit := unit_of(part)) is not None]
    for unit in units[1:]:
        if unit != units[0]:
            first, other = (shown_unit(one) or "no unit" for one in (units[0], unit))
            raise ExpressionError(f"units do not fit: {first} and {other}", node.column)
    return units[0] if units else None
