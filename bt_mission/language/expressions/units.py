"""Numbers with units in expressions: their dimensions, and their values in the unit of a field.

A quantity is computed in metres, seconds and radians, and in the unit of the field that it is for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from typing import Any, Self, TypeAlias

from bt_mission.base.units import (
    COMPUTED,
    DIMENSIONS,
    UNITS,
    Dimension,
    converted,
    in_base,
    shown_unit,
)
from bt_mission.language.expressions.syntax import (
    Arithmetic,
    Comparison,
    Conditional,
    Constant,
    FunctionCall,
    Name,
    Negation,
    SyntaxNode,
)
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.interface_units import SI

UnitOfName: TypeAlias = Callable[[Name], str]
"""Gives the unit of what a name stands for; empty where it is not known."""

_KEPT = frozenset(("abs", "round", "floor", "ceil"))
_COMMON = frozenset(("min", "max", "clamp", "uniform", "levy", "choice", "hypot"))
_OF_ANGLES = frozenset(("sin", "cos", "tan", "degrees"))


@dataclass(frozen=True)
class Quantity(Constant):
    """A number with its unit, such as `10 cm`; the value is in metres, seconds and radians."""

    number: float
    unit: str

    @classmethod
    def of(cls, column: int, number: float, unit: str) -> Quantity:
        """Return a quantity in a unit of `COMPUTED`."""
        return cls(column, in_base(number, unit), number, unit)

    @property
    def dimension(self) -> Dimension:
        """The powers of metres, seconds and radians."""
        return COMPUTED[self.unit]


def is_angle(unit: str) -> bool:
    """Return whether a unit is one of angles, or of rates of turning."""
    return DIMENSIONS[UNITS[unit][1]][2] != 0


class Measured(float):
    """The value of an input that was written with its unit.

    An angle is in that unit; lengths, times and speeds are in metres and seconds.
    """

    unit: str

    def __new__(cls, number: float, unit: str) -> Self:
        """Return a quantity in a unit."""
        base = UNITS[unit][1]
        kept = unit if is_angle(unit) else base
        quantity = super().__new__(cls, converted(number, unit, kept))
        quantity.unit = kept
        return quantity

    def __getnewargs__(self) -> tuple[float, str]:  # type: ignore[override]
        """Return what a copy is made of."""
        return float(self), self.unit


def as_quantity(root: SyntaxNode) -> Quantity | None:
    """Return the quantity that an expression consists of, signs included, or None."""
    match root:
        case Quantity():
            return root
        case Negation(operand=operand, sign=sign):
            inner = as_quantity(operand)
            return inner and Quantity.of(root.column, sign * inner.number, inner.unit)
    return None


def quantities(root: SyntaxNode) -> Iterator[Quantity]:
    """Yield the quantities of an expression."""
    if isinstance(root, Quantity):
        yield root
    for part in root.parts:
        yield from quantities(part)


# ---- dimensions ------------------------------------------------------------------------------


def dimension_of(
    node: SyntaxNode, leaf: Callable[[SyntaxNode], Dimension | None] = lambda _: None
) -> Dimension | None:
    """Return the dimension of a number; None where it is not known, or any will do.

    Args:
        node: A part of an expression.
        leaf: Returns the dimension of a part that is not a part of expressions, or a name.

    Raises:
        ExpressionError: Where metres are compared with, or added to, seconds, and the like.
    """
    match node:
        case Quantity():
            return node.dimension
        case Negation() | Arithmetic(symbol="+" | "-" | "%"):
            return _agreed(node, node.parts, leaf)
        case Arithmetic(symbol="*" | "/" as symbol, left=left, right=right):
            sign = 1 if symbol == "*" else -1
            first, second = _factor(left, leaf), _factor(right, leaf)
            if first is None or second is None:
                return None
            m, s, rad = (a + sign * b for a, b in zip(first, second, strict=True))
            return m, s, rad
        case FunctionCall(name=name) if name in _COMMON or name in _KEPT:
            return _agreed(node, node.parts[:1] if name in _KEPT else node.parts, leaf)
        case Conditional():
            dimension_of(node.condition, leaf)
            return _agreed(node, (node.value, node.otherwise), leaf)
        case Comparison():
            return _agreed(node, node.parts, leaf)
    return leaf(node)


def _factor(node: SyntaxNode, leaf: Callable[[SyntaxNode], Dimension | None]) -> Dimension | None:
    """Return the dimension of a factor; a bare number has none, rather than any."""
    is_bare = isinstance(node, Constant) and not isinstance(node, Quantity)
    return (0, 0, 0) if is_bare else dimension_of(node, leaf)


def _agreed(
    node: SyntaxNode,
    parts: tuple[SyntaxNode, ...],
    leaf: Callable[[SyntaxNode], Dimension | None],
) -> Dimension | None:
    """Return the one dimension that all parts have."""
    known = [dimension for part in parts if (dimension := dimension_of(part, leaf)) is not None]
    for dimension in known[1:]:
        if dimension != known[0]:
            first, other = (
                _written_unit(parts, dimension, leaf) for dimension in (known[0], dimension)
            )
            raise ExpressionError("BT-305", f"units do not match: {first} and {other}", node.column)
    return known[0] if known else None


def _written_unit(
    parts: tuple[SyntaxNode, ...],
    dimension: Dimension,
    leaf: Callable[[SyntaxNode], Dimension | None],
) -> str:
    """Return the unit of a dimension as its author wrote it, where it is one quantity."""
    part = next(part for part in parts if dimension_of(part, leaf) == dimension)
    written = as_quantity(part)
    return written.unit if written is not None else shown_unit(dimension) or "no unit"


# ---- in the unit of a field ------------------------------------------------------------------


def settled(root: SyntaxNode, unit: str, of_name: UnitOfName = lambda _: "") -> SyntaxNode:
    """Return an expression with its quantities as numbers in the unit of a field.

    Args:
        root: The expression.
        unit: Of the field; `SI`, or empty where it is not known.
        of_name: Gives the units of the names in comparisons, which decide there.

    Raises:
        ExpressionError: Where units do not fit, or an angle is for a field that does not say
            whether it is in degrees or in radians.
    """
    first = next(quantities(root), None)
    if first is None:
        return root
    wanted = DIMENSIONS.get(UNITS[unit][1]) if unit in UNITS else None
    if unit and unit != SI and wanted is None:
        message = f"the field is in {unit}, got {first.number:g} {first.unit}"
        raise ExpressionError("BT-305", message, first.column, "write the number without a unit")

    def dimension_of_name(node: SyntaxNode) -> Dimension | None:
        return COMPUTED.get(of_name(node)) if isinstance(node, Name) else None

    actual = dimension_of(root, dimension_of_name)
    if wanted is not None and actual is not None and actual != wanted:
        fitting = ", ".join(name for name, dimension in COMPUTED.items() if dimension == wanted)
        written = as_quantity(root)
        got = shown_unit(actual) or "a number without a unit"
        if written is not None:
            got = f"{written.number:g} {written.unit}"
        message = f"the field is in {unit} ({fitting}), got {got}"
        raise ExpressionError("BT-305", message, first.column)
    return _settled(root, unit, of_name, dimension_of_name)


def _settled(
    node: SyntaxNode,
    unit: str,
    of_name: UnitOfName,
    dimension_of_name: Callable[[SyntaxNode], Dimension | None],
) -> SyntaxNode:
    match node:
        case Quantity():
            return Constant(node.column, _number(node, unit))
        case FunctionCall(name=name) if name not in _COMMON and name not in _KEPT:
            unit = SI if name in _OF_ANGLES else ""
        case Comparison():
            dimension_of(node, dimension_of_name)
            unit = next((unit_name for name in _names(node) if (unit_name := of_name(name))), "")

    def inner(value: Any) -> Any:
        if isinstance(value, SyntaxNode):
            return _settled(value, unit, of_name, dimension_of_name)
        return tuple(map(inner, value)) if isinstance(value, tuple) else value

    return replace(node, **{field.name: inner(getattr(node, field.name)) for field in fields(node)})


def _number(quantity: Quantity, unit: str) -> float:
    """Return a quantity in the system that the unit of a field belongs to: cm/s has cm and s."""
    if quantity.unit == unit:
        return quantity.number
    if is_angle(quantity.unit) and not unit:
        degrees = f"{quantity.number:g} {quantity.unit}"
        message = f"{degrees}: the unit cannot be converted, as the unit of the field is unknown"
        raise ExpressionError("BT-305", message, quantity.column, "write the number without a unit")
    value = quantity.value
    assert isinstance(value, int | float)
    for part in unit.split("/") if unit in UNITS else ():
        size, base = UNITS[part]
        power = sum(a * b for a, b in zip(quantity.dimension, DIMENSIONS[base], strict=True))
        value = value / size**power
    return value


def _names(node: SyntaxNode) -> Iterator[Name]:
    if isinstance(node, Name):
        yield node
    for part in node.parts:
        yield from _names(part)


def added_names(node: SyntaxNode) -> Iterator[Name]:
    """Yield the names whose value is one with that of the whole, or is added to it."""
    match node:
        case Name():
            yield node
        case Negation() | Arithmetic(symbol="+" | "-" | "%"):
            parts = node.parts
        case Conditional():
            parts = (node.value, node.otherwise)
        case FunctionCall(name=name) if name in _COMMON or name in _KEPT:
            parts = node.parts[:1] if name in _KEPT else node.parts
        case _:
            return
    for part in () if isinstance(node, Name) else parts:
        yield from added_names(part)
