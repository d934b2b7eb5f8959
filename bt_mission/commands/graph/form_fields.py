"""The fields of a goal as lines of a form: their types, and what was typed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bt_mission.commands.graph.interface_description import InterfaceField, InterfacePart
from bt_mission.commands.graph.values import read_value, short
from bt_mission.language.message_types import (
    DURATION,
    POINT,
    POSE_STAMPED,
    SHORTHANDS,
    ListOf,
    MessageShape,
    Scalar,
    nested,
)

LARGEST_SHOWN = 2**16
"""Larger limits are not shown, since the type's name implies them."""


@dataclass(frozen=True)
class FormField(InterfaceField):
    """One line of a form: a number, a text, a boolean, a list, or a message with one value."""

    @property
    def kind(self) -> str:
        """Unit and type for people: ``deg float32``."""
        return " ".join(filter(None, (self.unit, self.type)))

    @property
    def is_truth(self) -> bool:
        """Whether it is a boolean, to be ticked."""
        return isinstance(self.shape, Scalar) and self.shape.type == "bool"

    @property
    def placeholder(self) -> str:
        """The text of an empty line."""
        return "" if isinstance(self.shape, MessageShape) else short(self.default)

    @property
    def note(self) -> str:
        """A note on the field: the author's comment, its form, its limits."""
        return "; ".join(filter(None, (self._form(), _limits(self.shape), self.text)))

    def read(self, text: str) -> tuple[Any, str]:
        """Return its value, and its error; a text is taken as typed, anything else is YAML.

        An empty line has neither: it leaves the field at its default.
        """
        shape = self.shape
        if isinstance(shape, Scalar) and shape.type == "text":
            fits = len(text) <= shape.most
            return text, "" if fits else f"expected at most {shape.most} characters"
        return read_value(text, shape)

    def _form(self) -> str:
        match self.shape:
            case MessageShape(name=name):
                return SHORTHANDS[name][0] if name in SHORTHANDS else ""
            case ListOf():
                return "a list: [...]"
        return ""


def lines_of(part: InterfacePart) -> list[FormField]:
    """Return the lines of a form for a message; a message with several fields is unfolded."""
    lines: list[FormField] = []
    for field in part.fields():
        is_message = isinstance(field.shape, MessageShape)
        is_unfolded = is_message and field.shape.name not in SHORTHANDS
        if not is_unfolded and not (lines and field.name.startswith(f"{lines[-1].name}.")):
            lines.append(FormField(**vars(field)))
    return lines


class _Placeholder(str):
    """A word to be replaced; it needs no quotes."""

    __slots__ = ()


_POINT_EXAMPLE = [1.0, 0.5, 0.0]
_EXAMPLES = {POSE_STAMPED: _POINT_EXAMPLE, POINT: _POINT_EXAMPLE, DURATION: 10.0}


def example(part: InterfacePart) -> str:
    """Return a message as YAML on one line, to be edited, with defaults and placeholders."""
    return _as_flow(nested({line.name: _example_of(line) for line in lines_of(part)}))


def _example_of(line: FormField) -> Any:
    if isinstance(line.shape, MessageShape):
        return _EXAMPLES[line.shape.name]
    item = line.shape.item if isinstance(line.shape, ListOf) else None
    if item is not None and item.name in _EXAMPLES:
        return [_EXAMPLES[item.name]]
    return _Placeholder(line.name.upper()) if line.default == "" else line.default


def texts(lines: list[FormField], fields: Mapping[str, Any]) -> dict[str, str]:
    """Return the texts of the lines for these fields of a message, by the lines' names."""
    texts = {}
    for line in lines:
        value: Any = fields
        for name in line.name.split("."):
            value = value.get(name) if isinstance(value, Mapping) else None
        if value is not None:
            texts[line.name] = value if isinstance(value, str) else _as_flow(value)
    return texts


def _as_flow(value: Any) -> str:
    """Return a plain value as YAML on one line."""
    match value:
        case bool():
            return "true" if value else "false"
        case _Placeholder():
            return value
        case str():
            return "'" + value.replace("'", "''") + "'"
        case Mapping():
            return (
                "{" + ", ".join(f"{name}: {_as_flow(item)}" for name, item in value.items()) + "}"
            )
        case list() | tuple():
            return "[" + ", ".join(_as_flow(item) for item in value) + "]"
    return repr(value)


def _limits(shape: Any) -> str:
    match shape:
        case Scalar(type="integer") if shape.most < LARGEST_SHOWN:
            return f"{shape.least} to {shape.most}"
        case Scalar(type="text") if shape.most < LARGEST_SHOWN:
            return f"at most {shape.most} characters"
        case ListOf(size=int() as size):
            return f"{size} items"
        case ListOf(most=int() as most):
            return f"at most {most} items"
    return ""
