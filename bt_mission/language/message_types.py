"""What a ROS message holds, as plain records, and how values of a mission become its fields.

`bt_mission.ros.interface_types` makes the shapes from the installed types; everything here is pure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from bt_mission.core.diagnostics import describe, did_you_mean, listed, quoted
from bt_mission.core.errors import BtMissionError
from bt_mission.language.expressions.expression import Late, Text
from bt_mission.language.expressions.values import Type

Path = tuple[str | int, ...]

POSE_STAMPED = "geometry_msgs/PoseStamped"
POINT = "geometry_msgs/Point"
DURATION = "builtin_interfaces/Duration"
SHORTHANDS: dict[str, tuple[str, Type]] = {
    POSE_STAMPED: ("a pose [x m, y m, yaw deg]", "list"),
    POINT: ("a point [x m, y m, z m]", "list"),
    DURATION: ("seconds", "number"),
}
"""Messages that may be written shorter: in which words, and the type of an expression for one."""
MAP_FRAME = "map"
LARGEST_FLOAT32 = 3.4028234663852886e38


@dataclass(frozen=True)
class Scalar:
    """A bool, a number or a text field, with its limits (a text's: its length)."""

    name: str
    type: Type
    least: float = -math.inf
    most: float = math.inf


@dataclass(frozen=True)
class ListOf:
    """An array or sequence: of exactly `size` items, or of at most `most`."""

    item: Shape
    size: int | None = None
    most: int | None = None

    @property
    def name(self) -> str:
        """The type's name as in an interface file."""
        bound = "" if self.most is None else f"<={self.most}"
        return f"{self.item.name}[{bound if self.size is None else self.size}]"


@dataclass(frozen=True)
class MessageShape:
    """A message with its fields in order."""

    name: str
    fields: Mapping[str, Shape]


Shape = Scalar | ListOf | MessageShape


@dataclass(frozen=True)
class ActionShapes:
    """What the three messages of an action hold."""

    goal: MessageShape
    result: MessageShape
    feedback: MessageShape


@dataclass(frozen=True)
class ServiceShapes:
    """What the two messages of a service hold."""

    request: MessageShape
    response: MessageShape


class _HintedError(BtMissionError):
    """A fault whose `hint` says what might help."""

    def __init__(self, message: str, hint: str | None = None) -> None:
        super().__init__(message if hint is None else f"{message}; {hint}")
        self.message = message
        self.hint = hint


class UnknownType(_HintedError):  # noqa: N818 - what it is says more than that it is an error
    """A ROS type that is not installed here."""


class UnknownField(_HintedError):  # noqa: N818 - what it is says more than that it is an error
    """A field that a message does not have."""


class Unknowable(Exception):  # noqa: N818 - not an error
    """Raised by a reader for a text whose value only the run can tell."""


@dataclass(frozen=True)
class TypeMismatch:
    """Something that does not fit: where (at the key or at the value), what, and a hint."""

    path: Path
    message: str
    hint: str | None = None
    at_key: bool = False

    def __str__(self) -> str:
        hint = f"; {self.hint}" if self.hint else ""
        return f"{'.'.join(str(part) for part in self.path)}: {self.message}{hint}"


Report = Callable[[TypeMismatch], None]
"""Told of everything that does not fit."""

Reader = Callable[[Path, Shape, Text | Late], Any]
"""Gives the value of a text for a field. Raises Unknowable where it has none yet."""


def field_at(message: MessageShape, dotted: str) -> Shape:
    """Return the shape of a field by its dotted name. Raises UnknownField."""
    shape: Shape = message
    for name in dotted.split("."):
        if not isinstance(shape, MessageShape):
            raise UnknownField(f"{quoted(dotted)}: {shape.name} has no fields of its own")
        if name not in shape.fields:
            text = f"no field {quoted(name)} in {shape.name} (its fields: {listed(shape.fields)})"
            raise UnknownField(text, did_you_mean(name, shape.fields))
        shape = shape.fields[name]
    return shape


def value_type(shape: Shape) -> Type | None:
    """Return the type a field has in an expression; None for a message."""
    match shape:
        case Scalar():
            return shape.type
        case ListOf():
            return "list"
    return None


def conform(shape: Shape, value: Any, read: Reader, report: Report, path: Path = ()) -> Any:
    """Return a value as the shape wants it (floats for float fields, mappings for messages).

    Everything that does not fit is reported, and then the result is of no use. Lists of three
    numbers become poses: x (m), y (m), yaw (deg) in the frame `map`; or points: x, y, z (m). A
    number becomes a duration (s).
    """
    if isinstance(value, Text | Late):
        try:
            value = read(path, shape, value)
        except Unknowable:
            return None
    match shape:
        case Scalar():
            return _scalar(shape, value, report, path)
        case ListOf():
            return _list(shape, value, read, report, path)
    if shape.name in (POSE_STAMPED, POINT) and isinstance(value, list | tuple):
        return _three(shape, value, read, report, path)
    if shape.name == DURATION and isinstance(value, int | float) and not isinstance(value, bool):
        return _duration(value, report, path)
    return _message(shape, value, read, report, path)


def _scalar(shape: Scalar, value: Any, report: Report, path: Path) -> Any:
    match shape.type:
        case "bool":
            return value if isinstance(value, bool) else _refuse(shape, value, report, path)
        case "text":
            return _text(shape, value, report, path)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return _refuse(shape, value, report, path)
    if not math.isfinite(value):
        report(TypeMismatch(path, f"expected a finite number ({shape.name}), got {value}"))
    elif shape.type == "integer" and not isinstance(value, int):
        hint = "round(...), floor(...) and // give whole numbers"
        report(TypeMismatch(path, f"expected an integer ({shape.name}), got {value}", hint))
    elif not shape.least <= value <= shape.most:
        limits = f"{shape.least:.12g} to {shape.most:.12g}"
        if shape.type == "integer":
            limits = f"{shape.least} to {shape.most}"
        report(TypeMismatch(path, f"the number {value} is outside {shape.name}, {limits}"))
    return float(value) if shape.type == "number" else value


def _text(shape: Scalar, value: Any, report: Report, path: Path) -> Any:
    if not isinstance(value, str):
        return _refuse(shape, value, report, path)
    if len(value) > shape.most:
        report(TypeMismatch(path, f"expected at most {shape.most} characters, got {len(value)}"))
    return value


_EXPECTED = {"bool": "a boolean", "text": "a string", "integer": "an integer"}


def _refuse(shape: Shape, value: Any, report: Report, path: Path) -> None:
    words = "a mapping" if isinstance(shape, MessageShape) else "a list"
    if isinstance(shape, Scalar):
        words = _EXPECTED.get(shape.type, "a number")
    report(TypeMismatch(path, f"expected {words} ({shape.name}), got {describe(value)}"))


def _list(shape: ListOf, value: Any, read: Reader, report: Report, path: Path) -> Any:
    if not isinstance(value, list | tuple):
        return _refuse(shape, value, report, path)
    if shape.size is not None and len(value) != shape.size:
        report(TypeMismatch(path, f"expected {shape.size} items ({shape.name}), got {len(value)}"))
    elif shape.most is not None and len(value) > shape.most:
        report(
            TypeMismatch(
                path, f"expected at most {shape.most} items ({shape.name}), got {len(value)}"
            )
        )
    return [
        conform(shape.item, part, read, report, (*path, index)) for index, part in enumerate(value)
    ]


def _message(shape: MessageShape, value: Any, read: Reader, report: Report, path: Path) -> Any:
    if not isinstance(value, Mapping):
        return _refuse(shape, value, report, path)
    filled = {}
    for name, part in value.items():
        if name not in shape.fields:
            message = (
                f"no field {quoted(name)} in {shape.name} (its fields: {listed(shape.fields)})"
            )
            hint = did_you_mean(name, shape.fields)
            report(TypeMismatch((*path, name), message, hint, at_key=True))
            continue
        filled[name] = conform(shape.fields[name], part, read, report, (*path, name))
    return filled


def completed(shape: Shape, value: Any) -> Any:
    """Return a value that conforms to a shape, its missing fields as 0, false and empty."""
    match shape:
        case MessageShape():
            given = value if isinstance(value, Mapping) else {}
            fields = shape.fields.items()
            return {name: _completed_field(name, part, given) for name, part in fields}
        case ListOf():
            return [] if value is None else value
    return _EMPTY[shape.type] if value is None else value


def _completed_field(name: str, shape: Shape, given: Mapping[str, Any]) -> Any:
    """Return a field; one that is given as None has a value that is not known."""
    is_unknown = name in given and given[name] is None
    return None if is_unknown else completed(shape, given.get(name))


_EMPTY: Mapping[Type, Any] = {"bool": False, "text": "", "integer": 0, "number": 0.0}
_COORDINATE = Scalar("float64", "number")


def _three(shape: MessageShape, value: Any, read: Reader, report: Report, path: Path) -> Any:
    """Return a pose on the map or a point, of three numbers."""
    if len(value) != 3:
        words, _ = SHORTHANDS[shape.name]
        report(TypeMismatch(path, f"expected {words}, got {describe(value)}"))
        return None
    parts = [
        conform(_COORDINATE, part, read, report, (*path, index)) for index, part in enumerate(value)
    ]
    if not all(isinstance(part, float) and math.isfinite(part) for part in parts):
        return None
    x, y, last = parts
    if shape.name == POINT:
        return {"x": x, "y": y, "z": last}
    half = math.radians(last) / 2.0
    return {
        "header": {"frame_id": MAP_FRAME},
        "pose": {
            "position": {"x": x, "y": y},
            "orientation": {"z": math.sin(half), "w": math.cos(half)},
        },
    }


_NS = 1_000_000_000
_LONGEST_S = 2**31 - 1


def _duration(seconds: float, report: Report, path: Path) -> Any:
    if not math.isfinite(seconds):
        report(TypeMismatch(path, f"expected a finite number of seconds, got {seconds}"))
    elif abs(seconds) > _LONGEST_S:
        message = f"{seconds:g} s are outside {DURATION}, -{_LONGEST_S} to {_LONGEST_S}"
        report(TypeMismatch(path, message))
    else:
        sec, nanosec = divmod(round(seconds * _NS), _NS)
        return {"sec": sec, "nanosec": nanosec}
    return None
