"""ROS types by name, as shapes, and messages filled from and read into plain values.

Checks of missions, the executive and the tools for graphs use it.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from rosidl_parser import definition

from bt_mission.base.diagnostics import did_you_mean, listed, quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.interface_files import share_folders
from bt_mission.language.expressions.expression import Late, Text
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.message_types import (
    LARGEST_FLOAT32,
    InterfaceShapes,
    ListOf,
    MessageShape,
    Scalar,
    Shape,
    TypeMismatch,
    Unknowable,
    UnknownType,
    conform,
)

_INDEX = Path("ament_index", "resource_index", "rosidl_interfaces")
_TEXT_BY_NAME = {"octet": "byte", "boolean": "bool", "float": "float32", "double": "float64"}


class FillError(BtMissionError):
    """Values that do not fit into a message: each with the dotted name of its field."""

    code = "BT-503"


MAX_NAME = 255
"""Characters of a type's name; longer ones are not possible as names of files either."""


FEEDBACK_TYPE = "_FeedbackMessage"
"""The suffix of the type of an action's feedback, after that of the action."""

KINDS = {
    "action": ("action", "nav2_msgs/action/Spin"),
    "srv": ("service", "std_srvs/srv/Trigger"),
    "msg": ("message", "std_msgs/msg/String"),
}
"""The folders of interface packages: their content, and an example."""


def action_type(name: str) -> Any:
    """Return the class of an action, "nav2_msgs/action/Spin". Raises UnknownType."""
    return _type("action", name)


def service_type(name: str) -> Any:
    """Return the class of a service, "std_srvs/srv/Trigger". Raises UnknownType."""
    return _type("srv", name)


def message_type(name: str) -> Any:
    """Return the class of a message, "std_msgs/msg/String". Raises UnknownType."""
    return _type("msg", name)


def topic_type(name: str) -> Any:
    """Return the class of a topic's type, also of an action's feedback. Raises UnknownType."""
    if "/action/" in name and name.endswith(FEEDBACK_TYPE):
        return action_type(name.removesuffix(FEEDBACK_TYPE)).Impl.FeedbackMessage
    return message_type(name)


def check_type(name: str, wanted: str, offered: Iterable[str], verb: str = "is a") -> None:
    """Compare the type of a resolved name with those in the graph, if any.

    Raises:
        BtMissionError: The graph has others, but not this one.
    """
    types = list(offered)
    if types and wanted not in types:
        article = verb.rpartition(" ")[2]
        raise BtMissionError(
            f"{name} {verb} {listed(types)}, not {article} {wanted}", code="BT-912"
        )


@cache
def _type(folder: str, name: str) -> Any:
    what, example = KINDS[folder]
    package, _, rest = name.partition("/")
    middle, _, short = rest.partition("/")
    if middle != folder or not package.isidentifier() or not short.isidentifier():
        raise UnknownType("BT-501", f"expected a type such as {example}, got {quoted(name)}")
    if len(name) > MAX_NAME or name not in _types_of(package):
        message = f"the {what} type {name} is not installed"
        raise UnknownType("BT-501", message, did_you_mean(name, installed(folder)))
    try:
        return getattr(importlib.import_module(f"{package}.{folder}"), short)
    except (ImportError, AttributeError) as error:
        raise UnknownType("BT-501", f"the {what} type {name} cannot be loaded: {error}") from error


def installed(folder: str) -> tuple[str, ...]:
    """Return the full names of all types installed in `action`, `srv` or `msg`, sorted."""
    packages = {path.name for index in _indexes() for path in index.iterdir()}
    names = (name for package in packages for name in _types_of(package))
    return tuple(sorted(name for name in names if name.split("/")[1] == folder))


@cache
def _types_of(package: str) -> frozenset[str]:
    """Return the types of a package in the ament index; importing shows fewer."""
    names = set()
    for index in _indexes():
        path = index / package
        for line in path.read_text(encoding="utf-8").splitlines() if path.is_file() else ():
            entry = Path(line)
            if entry.parent.name in KINDS:
                names.add(f"{package}/{entry.parent.name}/{entry.stem}")
    return frozenset(names)


def _indexes() -> list[Path]:
    return [index for share in share_folders() if (index := share / _INDEX).is_dir()]


_PARTS = {
    "Goal": "action",
    "Result": "action",
    "Feedback": "action",
    "Request": "srv",
    "Response": "srv",
}


@cache
def shape_of(message_class: Any) -> MessageShape:
    """Return what a message holds."""
    names = message_class.get_fields_and_field_types()
    fields = {
        name: _shape(slot) for name, slot in zip(names, message_class.SLOT_TYPES, strict=True)
    }
    package = message_class.__module__.partition(".")[0]
    name, _, part = message_class.__name__.rpartition("_")
    if name and part in _PARTS:
        return MessageShape(f"the {part.lower()} of {package}/{_PARTS[part]}/{name}", fields)
    return MessageShape(f"{package}/{message_class.__name__}", fields)


def shapes(name: str) -> InterfaceShapes:
    """Return what the messages of a type of any kind hold. Raises UnknownType."""
    match name.split("/"):
        case [_, "srv", _]:
            service = service_type(name)
            return InterfaceShapes(shape_of(service.Request), shape_of(service.Response), None)
        case [_, "msg", _]:
            message = shape_of(message_type(name))
            return InterfaceShapes(message, message, message)
    action = action_type(name)
    return InterfaceShapes(
        shape_of(action.Goal), shape_of(action.Result), shape_of(action.Feedback)
    )


def fields(message_class: Any) -> dict[str, str]:
    """Return a message's fields and the names of their types: {"angle": "float32", ...}."""
    return {name: shape.name for name, shape in shape_of(message_class).fields.items()}


def fill(message: Any, values: Mapping[str, Any]) -> Any:
    """Set fields of a message from plain values, and return it. Raises FillError.

    Texts that `resolve` left open are read as their field wants them; a list of three numbers
    becomes a pose.
    """
    problems: list[TypeMismatch] = []

    def read_late(path: tuple[str | int, ...], shape: Shape, late: Text | Late) -> Any:
        wants_text = isinstance(shape, Scalar) and shape.type == "text"
        assert isinstance(late, Late), "values are resolved before a message is filled"
        try:
            return late.as_text() if wants_text else late.as_value()
        except ExpressionError as error:
            problems.append(TypeMismatch("BT-503", path, str(error)))
            raise Unknowable from error

    kind: Any = type(message)
    filled = conform(shape_of(kind), values, read_late, problems.append)
    if problems:
        raise FillError("; ".join(str(problem) for problem in problems))
    return _assigned(message, shape_of(kind), filled)


def read(message: Any, dotted: str) -> Any:
    """Return a field by its dotted name as a plain value; messages as dicts."""
    value = message
    for name in dotted.split("."):
        value = getattr(value, name)
    return _plain(value)


def _plain(value: Any) -> Any:
    if hasattr(value, "get_fields_and_field_types"):
        return {name: _plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, bytes) and len(value) == 1:
        return value[0]
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return value.tolist() if hasattr(value, "tolist") else value


def _assigned(message: Any, shape: MessageShape, values: Mapping[str, Any]) -> Any:
    """Set fields of a message from values that conform to its shape, and return it."""
    for name, value in values.items():
        setattr(message, name, _ros_value(shape.fields[name], value, message, name))
    return message


def _ros_value(shape: Shape, value: Any, message: Any, name: str) -> Any:
    match shape:
        case MessageShape():
            return _assigned(getattr(message, name), shape, value)
        case ListOf(item=MessageShape() as item):
            made = item_class(message, name)
            return [_assigned(made(), item, part) for part in value]
        case ListOf(item=Scalar(name="byte")):
            return [bytes([part]) for part in value]
        case Scalar(name="byte"):
            return bytes([value])
    return value


def item_class(message: Any, name: str) -> Any:
    """Return the class of the items of a message's list."""
    names = list(message.get_fields_and_field_types())
    return _imported(message.SLOT_TYPES[names.index(name)].value_type)


def _imported(slot: Any) -> Any:
    return getattr(importlib.import_module(".".join(slot.namespaces)), slot.name)


def _shape(slot: Any) -> Shape:
    """Return the shape of a field of a generated class."""
    match slot:
        case definition.NamespacedType():
            return shape_of(_imported(slot))
        case definition.Array():
            return ListOf(_shape(slot.value_type), size=slot.size)
        case definition.BoundedSequence():
            return ListOf(_shape(slot.value_type), most=slot.maximum_size)
        case definition.AbstractSequence():
            return ListOf(_shape(slot.value_type))
        case definition.AbstractGenericString():
            bounded = slot.has_maximum_size()
            most = slot.maximum_size if bounded else float("inf")
            return Scalar(f"string<={most}" if bounded else "string", "text", most=most)
    return _basic(slot.typename)


def _basic(typename: str) -> Scalar:
    name = _TEXT_BY_NAME.get(typename, typename)
    if name == "bool":
        return Scalar(name, "bool")
    if name == "float32":
        return Scalar(name, "number", -LARGEST_FLOAT32, LARGEST_FLOAT32)
    if name.startswith("int"):
        half = 2 ** (int(name.removeprefix("int")) - 1)
        return Scalar(name, "integer", -half, half - 1)
    if name.startswith("uint"):
        return Scalar(name, "integer", 0, 2 ** int(name.removeprefix("uint")) - 1)
    if name == "byte":
        return Scalar(name, "integer", 0, 255)
    return Scalar(name, "number")
