"""The fields of ROS messages as plain records, and their values from a mission.

`bt_mission.ros.interface_types` makes the shapes from the installed types; everything here is pure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bt_mission.base.diagnostics import describe, did_you_mean, listed, quoted
from bt_mission.base.errors import HintedError
from bt_mission.base.stamps import NS
from bt_mission.language.expressions.expression import Late, Text
from bt_mission.language.expressions.values import Type
from bt_mission.language.interface_units import POSE_AXES

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
class InterfaceShapes:
    """What the messages of an interface hold: of a topic, all are its one message.

    Attributes:
        sends: The goal, the request or the message.
        keeps: The result, the response or the message.
        asks: The feedback or the message, which a condition reads; None for a service.
    """

    sends: MessageShape
    keeps: MessageShape
    asks: MessageShape | None


FindShapes = Callable[[str], InterfaceShapes]
"""Gives what the messages of a type hold, by its full name. Raises UnknownType."""


class UnknownType(HintedError):  # noqa: N818 - what it is says more than that it is an error
    """A ROS type that is not installed here."""


class UnknownField(HintedError):  # noqa: N818 - what it is says more than that it is an error
    """A field that a message does not have."""


class Unknowable(Exception):  # noqa: N818 - not an error
    """Raised by a reader for a text whose value only the run can tell."""


@dataclass(frozen=True)
class TypeMismatch:
    """Something that does not fit: where (at the key or at the value), what, and a hint."""

    code: str
    path: Path
    message: str
    hint: str | None = None
    at_key: bool = False

    def __str__(self) -> str:
        hint = f"; {self.hint}" if self.hint else ""
        return f"{'.'.join(str(part) for part in self.path)}: {self.message}{hint}"


NAV2_PORTS: Mapping[str, str] = {
    "backup_dist": "target",
    "backup_speed": "speed",
    "dist_to_travel": "target",
    "goal": "pose",
    "goals": "poses",
    "spin_dist": "target_yaw",
}
"""Ports of Nav2's nodes for BehaviorTree.CPP, and the fields of goals that they set."""

Report = Callable[[TypeMismatch], None]
"""Called with everything that does not fit."""

Reader = Callable[[Path, Shape, Text | Late], Any]
"""Gives the value of a text for a field. Raises Unknowable where it has none yet."""


def field_at(message: MessageShape, dotted: str) -> Shape:
    """Return the shape of a field by its dotted name. Raises UnknownField."""
    shape: Shape = message
    for name in dotted.split("."):
        if not isinstance(shape, MessageShape):
            raise UnknownField("BT-502", f"{quoted(dotted)}: {shape.name} has no fields")
        if name not in shape.fields:
            raise UnknownField("BT-502", *_unknown_field(shape, name))
        shape = shape.fields[name]
    return shape


def too_much(field: str, shape: MessageShape) -> str:
    """Return what is wrong with a field that is a message where a value is wanted."""
    fields = listed(f"{field}.{name}" for name in shape.fields)
    return f"{quoted(field)} is a {shape.name}; name one of its fields: {fields}"


def value_type(shape: Shape) -> Type | None:
    """Return the type a field has in an expression; None for a message."""
    match shape:
        case Scalar():
            return shape.type
        case ListOf():
            return "list"
    return None


def conform(shape: Shape, value: Any, read: Reader, report: Report) -> Any:
    """Return a value as the shape wants it (floats for float fields, mappings for messages).

    Everything that does not fit is reported, and then the result is of no use. Lists of three
    numbers become poses: x (m), y (m), yaw (deg) in the frame `map`; or points: x, y, z (m). A
    mapping of x, y and yaw is a pose, too. A number becomes a duration (s).
    """
    return _Conforming(read, report).value(shape, value, ())


_EXPECTED = {"bool": "a boolean", "text": "a string", "integer": "an integer"}
_COORDINATE = Scalar("float64", "number")
LONGEST_DURATION_S = 2**31 - 1


@dataclass(frozen=True)
class _Conforming:
    read: Reader
    report: Report

    def value(self, shape: Shape, value: Any, path: Path) -> Any:
        if isinstance(value, Text | Late):
            try:
                value = self.read(path, shape, value)
            except Unknowable:
                return None
        match shape:
            case Scalar():
                return self.scalar(shape, value, path)
            case ListOf():
                return self.list(shape, value, path)
        if shape.name in (POSE_STAMPED, POINT) and isinstance(value, list | tuple):
            return self.three(shape, value, path)
        if shape.name == POSE_STAMPED and isinstance(value, Mapping) and _is_pose(value):
            numbers = [value.get(axis, 0.0) for axis in POSE_AXES]
            return self.three(shape, numbers, path, POSE_AXES)
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if shape.name == DURATION and is_number:
            return self.duration(value, path)
        return self.message(shape, value, path)

    def refuse(self, path: Path, message: str, hint: str | None = None) -> None:
        self.report(TypeMismatch("BT-503", path, message, hint))

    def refuse_kind(self, shape: Shape, value: Any, path: Path) -> None:
        words = "a mapping" if isinstance(shape, MessageShape) else "a list"
        if isinstance(shape, Scalar):
            words = _EXPECTED.get(shape.type, "a number")
        self.refuse(path, f"expected {words} ({shape.name}), got {describe(value)}")

    def scalar(self, shape: Scalar, value: Any, path: Path) -> Any:
        match shape.type, value:
            case ("bool", bool()):
                return value
            case ("text", str()):
                if len(value) > shape.most:
                    self.refuse(path, f"expected at most {shape.most} characters, got {len(value)}")
                return value
            case ("integer" | "number", int() | float()) if not isinstance(value, bool):
                return self.number(shape, value, path)
        return self.refuse_kind(shape, value, path)

    def number(self, shape: Scalar, value: float, path: Path) -> float:
        if not math.isfinite(value):
            self.refuse(path, f"expected a finite number ({shape.name}), got {value}")
        elif shape.type == "integer" and not isinstance(value, int):
            hint = "round(...), floor(...) and // return integers"
            self.refuse(path, f"expected an integer ({shape.name}), got {value}", hint)
        elif not shape.least <= value <= shape.most:
            limits = f"{shape.least:.12g} to {shape.most:.12g}"
            if shape.type == "integer":
                limits = f"{shape.least} to {shape.most}"
            self.refuse(path, f"the number {value} is outside {shape.name}, {limits}")
        return float(value) if shape.type == "number" else value

    def list(self, shape: ListOf, value: Any, path: Path) -> Any:
        if not isinstance(value, list | tuple):
            return self.refuse_kind(shape, value, path)
        count = len(value)
        if shape.size is not None and count != shape.size:
            self.refuse(path, f"expected {shape.size} items ({shape.name}), got {count}")
        elif shape.most is not None and count > shape.most:
            self.refuse(path, f"expected at most {shape.most} items ({shape.name}), got {count}")
        return self.items(shape.item, value, path)

    def items(self, shape: Shape, values: Any, path: Path, keys: Sequence[str] = ()) -> Any:
        places: Sequence[str | int] = keys or range(len(values))
        return [
            self.value(shape, part, (*path, key)) for key, part in zip(places, values, strict=True)
        ]

    def message(self, shape: MessageShape, value: Any, path: Path) -> Any:
        if not isinstance(value, Mapping):
            return self.refuse_kind(shape, value, path)
        filled = {}
        for name, part in value.items():
            if name in shape.fields:
                filled[name] = self.value(shape.fields[name], part, (*path, name))
                continue
            text, hint = _unknown_field(shape, name)
            self.report(TypeMismatch("BT-502", (*path, name), text, hint, at_key=True))
        return filled

    def three(self, shape: MessageShape, value: Any, path: Path, keys: Sequence[str] = ()) -> Any:
        """Return a pose on the map or a point, of three numbers, which may have keys."""
        if len(value) != 3:
            words, _ = SHORTHANDS[shape.name]
            return self.refuse(path, f"expected {words}, got {describe(value)}")
        parts = self.items(_COORDINATE, value, path, keys)
        if not all(isinstance(part, float) and math.isfinite(part) for part in parts):
            return None
        x, y, last = parts
        if shape.name == POINT:
            return {"x": x, "y": y, "z": last}
        half = math.radians(last) / 2.0
        turned = {"z": math.sin(half), "w": math.cos(half)}
        pose = {"position": {"x": x, "y": y}, "orientation": turned}
        return {"header": {"frame_id": MAP_FRAME}, "pose": pose}

    def duration(self, seconds: float, path: Path) -> Any:
        if not math.isfinite(seconds):
            return self.refuse(path, f"expected a finite number of seconds, got {seconds}")
        if abs(seconds) > LONGEST_DURATION_S:
            limits = f"-{LONGEST_DURATION_S} to {LONGEST_DURATION_S}"
            return self.refuse(path, f"{seconds:g} s are outside {DURATION}, {limits}")
        sec, nanosec = divmod(round(seconds * NS), NS)
        return {"sec": sec, "nanosec": nanosec}


def _is_pose(value: Mapping[str, Any]) -> bool:
    """Return whether a mapping is a pose of numbers: x (m), y (m), and perhaps yaw (deg)."""
    return {"x", "y"} <= value.keys() <= set(POSE_AXES)


def _unknown_field(message: MessageShape, name: str) -> tuple[str, str | None]:
    known = message.fields
    text = f"no field {quoted(name)} in {message.name} (its fields: {listed(known)})"
    field = NAV2_PORTS.get(name, name)
    return text, did_you_mean(field if field in known else name, known)


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


def nested(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return fields with dotted names as mappings in mappings."""
    whole: dict[str, Any] = {}
    for dotted, value in fields.items():
        *path, last = dotted.split(".")
        part = whole
        for name in path:
            part = part.setdefault(name, {})
        part[last] = value
    return whole
