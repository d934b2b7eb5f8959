"""What an expression computes with: numbers, truth, text and lists, and the bounds on them."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Literal

from bt_mission.base.diagnostics import quoted
from bt_mission.base.errors import BtMissionError

Plain = bool | int | float | str | list["Plain"] | dict[str, "Plain"]
"""A value of the mission language. Mappings come from messages only, inside lists."""

Type = Literal["integer", "number", "bool", "text", "list"]
"""The type of an expression; every integer is a number too. None stands for "not known"."""

MAX_MAGNITUDE = 2**64
"""The largest integer an expression may reach; no ROS field holds a larger one."""

WORDS: dict[Type | None, str] = {
    "integer": "an integer",
    "number": "a number",
    "bool": "a boolean",
    "text": "a string",
    "list": "a list",
    None: "a value",
}


class ExpressionError(BtMissionError):
    """An expression that cannot be read or evaluated; `column` counts from 1 in its text."""

    def __init__(self, code: str, message: str, column: int = 1, hint: str | None = None) -> None:
        super().__init__(message, code=code)
        self.message = message
        self.column = column
        self.hint = hint

    def __str__(self) -> str:
        hint = f"; {self.hint}" if self.hint else ""
        return f"{self.message}{hint} (column {self.column})"


@dataclass(frozen=True)
class NoValue:
    """Stands for the value of a variable that has none at present, with the reason."""

    reason: str

    def __repr__(self) -> str:
        return f"no value: {self.reason}"


class LooseText(ExpressionError):  # noqa: N818 - what it is says more than that it is an error
    """A text with more words behind an expression: probably no formula."""


_TYPES: Mapping[type, Type] = {
    bool: "bool",
    int: "integer",
    float: "number",
    str: "text",
    list: "list",
    tuple: "list",
}
"""Of most values; others are of a subclass."""


def type_of(value: object) -> Type | None:
    """Return the type of a value, or None for what the language has no type for."""
    known = _TYPES.get(type(value))
    if known is not None:
        return known
    match value:
        case bool():
            return "bool"
        case int():
            return "integer"
        case float():
            return "number"
        case str():
            return "text"
        case list() | tuple():
            return "list"
    return None


def fits(actual: Type | None, wanted: Type) -> bool:
    """Return whether a value of a type will do where another is wanted; unknown will."""
    return actual is None or actual == wanted or (actual == "integer" and wanted == "number")


def joined(types: Collection[Type | None]) -> Type | None:
    """Return the common type of values of these types, or None."""
    distinct = frozenset(types)
    if distinct == {"integer", "number"}:
        return "number"
    return next(iter(distinct)) if len(distinct) == 1 else None


def show(value: object) -> str:
    """Return a value as a log line shows it: six significant digits, true and false."""
    match value:
        case bool():
            return "true" if value else "false"
        case float():
            return f"{value:.6g}"
        case list() | tuple():
            return ", ".join(show(item) for item in value)
    return str(value)


def bounded(value: float, column: int, *, was_finite: bool) -> float:
    """Return a number an operation gave; refuse one that it made too large or undefined."""
    if isinstance(value, int):
        if abs(value) > MAX_MAGNITUDE:
            raise ExpressionError("BT-406", "the result is too large", column)
    elif was_finite and not math.isfinite(value):
        what = "not a number" if math.isnan(value) else "too large"
        raise ExpressionError("BT-406", f"the result is {what}", column)
    return value


def mismatch(value: object, wanted: Type, column: int) -> ExpressionError:
    """Return the error for a value of the wrong type."""
    got = WORDS[type_of(value)] if isinstance(value, dict) else _described(value)
    return ExpressionError("BT-404", f"expected {WORDS[wanted]}, got {got}", column)


def _described(value: object) -> str:
    match value:
        case bool():
            return show(value)
        case str():
            return f"string {quoted(value)}"
        case list() | tuple():
            return f"a list of {len(value)}"
    return str(value)
