"""The types of values that messages and leaves in Python give."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import reduce
from typing import Any, Literal, TypeAlias

from bt_mission.commands.prove.regions import MOST_USUAL, Line
from bt_mission.language.message_types import (
    ListOf,
    MessageShape,
    Scalar,
    Shape,
    UnknownField,
    field_at,
)
from bt_mission.language.plugins import find_class
from bt_mission.ros.interface_types import item_class, shape_of

DomainKind: TypeAlias = Literal["double", "float", "integer", "bool", "text", "list", "other"]


@dataclass(frozen=True)
class Domain:
    """The values that something may have.

    Attributes:
        kind: Of a number, its precision.
        default: The value of a new message.
        least: Of an integer.
        most: Of an integer.
        item: Of a list, its elements.
        size: Of a list, its length if it is fixed.
        most_items: Of a list, its greatest length; None for any.
    """

    kind: DomainKind
    default: Any
    least: int = -(2**63)
    most: int = 2**63 - 1
    item: Domain | None = None
    size: int | None = None
    most_items: int | None = None

    @property
    def line(self) -> Line | None:
        """The usual numbers; None for values of another type."""
        if self.kind == "integer":
            most = int(MOST_USUAL)
            return Line("integer", max(self.least, -most), min(self.most, most))
        return Line.of_float(self.kind) if self.kind in ("double", "float") else None

    @property
    def unusual(self) -> tuple[Any, ...]:
        """Numbers that are a fault, where no usual one does the same."""
        if self.kind == "integer":
            most = int(MOST_USUAL)
            return tuple(end for end in (self.least, self.most) if not -most <= end <= most)
        if self.kind not in ("double", "float"):
            return ()
        far = Line.of_float(self.kind, 3e38 if self.kind == "float" else 1e300)
        return math.nan, math.inf, -math.inf, far.at(far.last), far.at(far.first)


def domain_of(shape: Shape, default: Any) -> Domain:
    """Return the values of a field.

    Args:
        shape: Of the field.
        default: Its value in a new message.
    """
    if isinstance(default, bytes):
        return Domain("other", default)
    match shape:
        case Scalar(type="bool"):
            return Domain("bool", bool(default))
        case Scalar(type="text"):
            return Domain("text", default)
        case Scalar(type="integer"):
            return Domain("integer", default, int(shape.least), int(shape.most))
        case Scalar(type="number"):
            return Domain("float" if "32" in shape.name else "double", float(default))
        case ListOf(item=Scalar() as item):
            first = {"bool": False, "text": "", "integer": 0}.get(str(item.type), 0.0)
            inner = domain_of(item, first)
            return Domain("list", list(default), item=inner, size=shape.size, most_items=shape.most)
    return Domain("other", default)


def domain_in(message: Any, dotted: str, default: Any) -> Domain:
    """Return the values of a field of a message, by its dotted name."""
    try:
        kind: Any = type(message)
        shape = field_at(shape_of(kind), dotted)
    except UnknownField:
        return Domain("other", default)
    if isinstance(shape, ListOf) and isinstance(shape.item, MessageShape):
        *path, last = dotted.split(".")
        part = reduce(getattr, path, message)
        item = Domain("other", item_class(part, last)())
        return Domain("list", list(default), item=item, size=shape.size, most_items=shape.most)
    return domain_of(shape, default)


def attribute_domain(node: Any, file: str, attribute: str) -> Domain | None:
    """Return the values of an attribute of a class in Python; None where its type is not known.

    The type is that of the attribute of the class, or of a new object.

    Args:
        node: Names the class.
        file: The file of the node.
        attribute: Its name.
    """
    try:
        kind = find_class(node.target, file)
        value = getattr(kind, attribute, None)
        value = getattr(kind(node.label), attribute, None) if value is None else value
    except Exception:  # noqa: BLE001 - a class of the user's may raise anything
        return None
    domain = domain_like(value)
    return None if domain.kind == "other" else domain


def domain_like(value: Any) -> Domain:
    """Return the values of the type of a value of Python."""
    match value:
        case bool():
            return Domain("bool", value)
        case int():
            return Domain("integer", value)
        case float():
            return Domain("double", value)
        case str():
            return Domain("text", value)
        case list() | tuple():
            first = domain_like(value[0]) if value else Domain("double", 0.0)
            return Domain("list", list(value), item=first)
    return Domain("other", value)
