"""What can be wrong with a message: ready-made changes, and those that a test makes."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration, Time
from std_msgs.msg import Header

from bt_mission.base.errors import described
from bt_mission.ros.interface_types import FillError, fill, message_type
from bt_mission.scenarios.faults.errors import ScenarioError, no_such

STAMP_S = 10
"""A wrong stamp is off by this, s."""


def changed_by(how: str | Callable[[Any], Any], field: str | None) -> Callable[[Any], Any]:
    """Return what changes a message, or gives another in its place.

    Args:
        how: One of :data:`READY_MADE`, or a function of the test's own.
        field: Dotted name of the one field that is affected.
    """
    if isinstance(how, str):
        ready_made = READY_MADE[how]

        def change(message: Any) -> Any:
            owner, names = _find(message, field)
            if not ready_made(owner, names):
                what = field or type(message).__name__
                raise ScenarioError(f"corrupt: {what} has nothing that '{how}' can change")
            return message

        return change

    def change_freely(message: Any) -> Any:
        try:
            other = how(message)
        except Exception as error:
            raise ScenarioError(f"corrupt: the function raised {described(error)}") from error
        if other is not None and type(other) is not type(message):
            raise ScenarioError(
                f"corrupt: expected the function to change the {type(message).__name__}, or to "
                f"give another, got {other!r}"
            )
        return message if other is None else other

    return change_freely


def setting(what: str, fields: Mapping[str, Any]) -> Callable[[Any], Any]:
    """Return what gives fields of a message other values, and returns the message.

    Args:
        what: The fault, for errors.
        fields: Values by dotted names.

    It raises ScenarioError for a field or a value that does not fit.
    """

    def change(message: Any) -> Any:
        for field, value in fields.items():
            owner, (name,) = _find(message, field)
            try:
                _give(owner, name, value)
            except FillError as error:
                raise ScenarioError(f"{what}: {error}") from error
        return message

    return change


def _give(owner: Any, name: str, value: Any) -> None:
    """Give a field a value; sensors send NaN and infinite numbers, too. Raises FillError."""
    is_list = isinstance(value, tuple)
    parts = value if is_list else (value,)
    odd = [index for index, part in enumerate(parts) if _is_odd(part)]
    finite = tuple(0.0 if index in odd else part for index, part in enumerate(parts))
    fill(owner, {name: finite if is_list else finite[0]})
    present = getattr(owner, name)
    if odd and not isinstance(present[odd[0]] if is_list else present, float | np.floating):
        raise FillError(f"{name}: {parts[odd[0]]} is no value of its type")
    if not is_list and odd:
        setattr(owner, name, value)
    for index in odd if is_list else ():
        present[index] = value[index]


def _is_odd(value: Any) -> bool:
    return isinstance(value, float) and not math.isfinite(value)


def restamp(message: Any, like: Any) -> None:
    """Give a message the stamps of another of its type.

    Raises:
        ScenarioError: When it has none.
    """
    stamps = [
        (message_stamp.header, other.header) for message_stamp, other in _stamped(message, like)
    ]
    if not stamps:
        raise ScenarioError(f"freeze: a {type(message).__name__} has no stamp to refresh")
    for header, other in stamps:
        header.stamp = other.stamp


def _stamped(message: Any, like: Any) -> Iterator[tuple[Any, Any]]:
    if hasattr(message, "header"):
        yield message, like
    elif hasattr(message, "transforms"):
        yield from zip(message.transforms, like.transforms, strict=False)


def _find(message: Any, field: str | None) -> tuple[Any, list[str]]:
    """The message that holds a field, and the field; all of its fields where none is named."""
    if field is None:
        return message, list(message.get_fields_and_field_types())
    *path, last = field.split(".")
    for name in path:
        message = getattr(message, _checked(message, name))
    return message, [_checked(message, last)]


def _checked(message: Any, name: str) -> str:
    if not hasattr(message, "get_fields_and_field_types"):
        raise ScenarioError(f"there is no field '{name}' in {message!r}, a plain value")
    known = list(message.get_fields_and_field_types())
    if name not in known:
        raise no_such(f"field of {type(message).__name__}", name, known)
    return name


# ---- ready-made: each changes fields of a message, and tells whether there was any to change ----


ReadyMade = Callable[[Any, list[str]], bool]


def _values(change: Callable[[Any], Any]) -> ReadyMade:
    """Return what changes all values in fields and below them; headers and times stay."""

    def apply(message: Any, names: list[str]) -> bool:
        has_changed = False
        for name in names:
            value = getattr(message, name)
            if isinstance(value, Header | Time | Duration):
                continue
            parts = value if isinstance(value, list) else [value]
            if parts and hasattr(parts[0], "get_fields_and_field_types"):
                for part in parts:
                    has_changed |= apply(part, list(part.get_fields_and_field_types()))
            elif (changed := change(value)) is not None:
                setattr(message, name, changed)
                has_changed = True
        return has_changed

    return apply


def _headers(change: Callable[[Header], None]) -> ReadyMade:
    """Return what changes the headers of a message."""

    def apply(message: Any, _: list[str]) -> bool:
        stamped = [first for first, _ in _stamped(message, message)]
        for stamped_message in stamped:
            change(stamped_message.header)
        return bool(stamped)

    return apply


def _float(number: float) -> ReadyMade:
    def change(value: Any) -> Any:
        if isinstance(value, float):
            return number
        if isinstance(value, array) and value.typecode in "fd":
            return array(value.typecode, [number] * len(value))
        if isinstance(value, np.ndarray) and value.dtype.kind == "f":
            return np.full_like(value, number)
        return None

    return _values(change)


def _zero(value: Any) -> Any:
    if isinstance(value, bool | int | float):
        return type(value)(0)
    if isinstance(value, array):
        return array(value.typecode, bytes(value.itemsize * len(value)))
    return np.zeros_like(value) if isinstance(value, np.ndarray) else None


def _empty(value: Any) -> Any:
    if isinstance(value, array):
        return array(value.typecode)
    return type(value)() if isinstance(value, list | str | bytes) else None


def _misplace(header: Header) -> None:
    header.frame_id = "nowhere"


def _stamp(by_s: int) -> ReadyMade:
    def change(header: Header) -> None:
        stamp = header.stamp
        header.stamp = Time(sec=max(0, stamp.sec + by_s), nanosec=stamp.nanosec)

    return _headers(change)


READY_MADE: dict[str, ReadyMade] = {
    "nan": _float(math.nan),
    "inf": _float(math.inf),
    "zeros": _values(_zero),
    "empty": _values(_empty),
    "wrong frame": _headers(_misplace),
    "old stamp": _stamp(-STAMP_S),
    "future stamp": _stamp(STAMP_S),
}

DRAWN = ("nan", "zeros", "empty", "old stamp", "wrong frame")
"""Those that are drawn at random."""


@cache
def corruptions_of(type_name: str) -> tuple[str, ...]:
    """Return the corruptions to draw from that change a message of a type."""
    message = message_type(type_name)
    fields = list(message.get_fields_and_field_types())
    return tuple(name for name in DRAWN if READY_MADE[name](message(), fields))
