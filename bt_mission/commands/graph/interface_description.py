"""The description of a ROS type: its fields with types, units, defaults and comments."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

from bt_mission.base.interface_files import file_text, share_folders
from bt_mission.commands.graph.values import flat, plain
from bt_mission.language.interface_comments import InterfaceText, Section, read_interface
from bt_mission.language.message_types import MessageShape, Scalar, Shape, field_at
from bt_mission.ros.interface_types import action_type, message_type, service_type, shape_of

ACTION_PARTS = ("goal", "result", "feedback")
SERVICE_PARTS = ("request", "response")


@dataclass(frozen=True)
class InterfaceField:
    """One field of a message, with its dotted name; the unit is empty if it is not known."""

    name: str
    shape: Shape
    unit: str
    default: Any
    text: str

    @property
    def type(self) -> str:
        """The type's name as in an interface file."""
        return self.shape.name

    @property
    def depth(self) -> int:
        """Its level of nesting."""
        return self.name.count(".")


@dataclass(frozen=True)
class InterfacePart:
    """One message of an interface: goal, result, feedback, request, response, or the message.

    `cls` is its Python class, `section` the author's comments.
    """

    name: str
    cls: Any
    section: Section

    @property
    def shape(self) -> MessageShape:
        """The shape of its message."""
        return shape_of(self.cls)

    def fields(self) -> list[InterfaceField]:
        """Return its fields in order, nested ones after their parent."""
        return list(_fields(self.shape, self.section, plain(self.cls()), "", ""))

    def units(self) -> dict[str, str]:
        """The units of its fields by their dotted names, where they are known."""
        known = {field.name: field.unit for field in self.fields() if field.unit}
        # A time is shown as one number of seconds; nested fields of ours have units.
        return known | {name: "s" for name, _ in flat(plain(self.cls())) if self._is_time(name)}

    def _is_time(self, dotted: str) -> bool:
        shape = field_at(self.shape, dotted)
        return isinstance(shape, MessageShape) and set(shape.fields) == {"sec", "nanosec"}


@dataclass(frozen=True)
class InterfaceDescription:
    """A ROS type with all its parts and its author's comments."""

    type: str
    text: str
    parts: tuple[InterfacePart, ...]

    def part(self, name: str) -> InterfacePart:
        """The part of a name: goal, result, ..."""
        return next(part for part in self.parts if part.name == name)


@cache
def describe_interface(type_name: str) -> InterfaceDescription:
    """Return the description of an action, service or message type. Raises UnknownType."""
    match type_name.split("/"):
        case [_, "srv", _]:
            class_ = service_type(type_name)
            classes = dict(zip(SERVICE_PARTS, (class_.Request, class_.Response), strict=True))
        case [_, "msg", _]:
            classes = {"message": message_type(type_name)}
        case _:
            class_ = action_type(type_name)
            messages = (class_.Goal, class_.Result, class_.Feedback)
            classes = dict(zip(ACTION_PARTS, messages, strict=True))
    interface = _interface(type_name)
    parts = tuple(
        InterfacePart(name, cls, interface.section(index))
        for index, (name, cls) in enumerate(classes.items())
    )
    return InterfaceDescription(type_name, interface.text, parts)


@cache
def _interface(type_name: str) -> InterfaceText:
    """Return the content of the installed interface file; empty without it."""
    try:
        text = file_text(type_name, share_folders())
    except (OSError, UnicodeDecodeError):
        text = None
    return InterfaceText("", ()) if text is None else read_interface(text)


def _fields(
    shape: MessageShape, section: Section, defaults: Any, prefix: str, unit: str
) -> Iterator[InterfaceField]:
    for name, inner in shape.fields.items():
        remark = section.remark(name)
        default = defaults[name]
        own = remark.unit or unit
        yield InterfaceField(prefix + name, inner, own, default, remark.text)
        if isinstance(inner, MessageShape):
            package, short = inner.name.split("/")
            inner_section = _interface(f"{package}/msg/{short}").section(0)
            # The unit of a point is that of its coordinates.
            is_flat = all(isinstance(part, Scalar) for part in inner.fields.values())
            yield from _fields(
                inner, inner_section, default, f"{prefix}{name}.", own if is_flat else ""
            )
