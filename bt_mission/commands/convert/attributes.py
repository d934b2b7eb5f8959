"""Values with places, and how each sort of value is read from an attribute and written as one.

`{name}` is the variable `$name`. A number, true, false and a list in `[...]` are themselves, and
anything else is a text. A text that would be read as something else is in double quotes, as in
JSON.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from bt_mission.base.diagnostics import (
    MOST_DIAGNOSTICS,
    Diagnostic,
    InputError,
    diagnostic_at,
    did_you_mean,
    listed,
    quoted,
)
from bt_mission.base.yaml.composer import MAX_INTEGER, At, Place, compose
from bt_mission.base.yaml.document import read_text as read_yaml
from bt_mission.commands.convert.elements import Attribute, XmlSource
from bt_mission.commands.convert.yaml_text import escaped, flow
from bt_mission.language.nodes.fields import SECONDS, VARIABLE, is_quantity

GLOBAL = "global variables ('@') are not supported; give the variable to the tree as a port"

LABELS = {
    "number": "double",
    "integer": "int",
    "bool": "bool",
    "text": "std::string",
    "list": "list",
}
"""Our types, and what Groot 2 shows as theirs."""

_REFERENCE = re.compile(rf"\{{({VARIABLE.pattern})\}}")
_VARIABLE = re.compile(rf"\$?({VARIABLE.pattern})")
_THOUSANDTH = re.compile(rf"\$({VARIABLE.pattern}) / 1000")
_LARGEST_MSEC = 2**31 - 1
_NUMBER = re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?")
_INTEGER = re.compile(r"[-+]?[0-9]+")
_ILLEGAL = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_WORDS = {"true": True, "false": False}


class MisreadError(Exception):
    """An attribute with an invalid value: each diagnostic has code, place, message and hint."""

    def __init__(self, *diagnostics: tuple[str, At, str, str | None]) -> None:
        super().__init__(diagnostics)
        self.diagnostics = diagnostics


# ---- values with places ----------------------------------------------------------------------


@dataclass(frozen=True)
class LocatedValue:
    """A value as in a YAML file, with its place in the XML file."""

    data: Any
    place: Place


Entry = tuple[str, At, LocatedValue]
"""A key, where it stands, and its value."""


def located(data: Any, at: At) -> LocatedValue:
    """Return data at one place; the located values in a list keep their own places."""
    if isinstance(data, LocatedValue):
        return data
    if isinstance(data, list):
        items = [located(value, at) for value in data]
        place = Place(*at, parts=[item.place for item in items])
        return LocatedValue([item.data for item in items], place)
    return LocatedValue(data, Place(*at))


def mapping(at: At, entries: Iterable[Entry]) -> LocatedValue:
    """Return a mapping; of two entries with one key the later counts."""
    data: dict[str, Any] = {}
    keys: dict[str, At] = {}
    parts: dict[str, Place] = {}
    for key, key_at, part in entries:
        data[key], keys[key], parts[key] = part.data, key_at, part.place
    return LocatedValue(data, Place(*at, keys=keys, parts=parts))


def plain_text(attribute: Attribute) -> LocatedValue:
    """Return the value of an attribute as it is, so that errors can point to a column in it."""
    return LocatedValue(attribute.value, Place(*attribute.value_at, text=attribute.value))


def _moved(place: Place, at: At) -> Place:
    """Return a place within a text as a place in the file that the text begins at, on one line."""
    line, column = at
    parts: dict[str, Place] | list[Place] | None = None
    if isinstance(place.parts, dict):
        parts = {key: _moved(part, at) for key, part in place.parts.items()}
    elif isinstance(place.parts, list):
        parts = [_moved(part, at) for part in place.parts]
    keys = {key: (line, column + start - 1) for key, (_, start) in (place.keys or {}).items()}
    column += place.column - 1
    return Place(line, column, keys if place.keys is not None else None, parts, place.text)


# ---- what a value is -------------------------------------------------------------------------


def number(text: str) -> int | float | None:
    """Return the number in a text; None for anything else, and for a number that is too large."""
    if not _NUMBER.fullmatch(text) or len(text) > 400:
        return None
    if _INTEGER.fullmatch(text):
        whole = int(text)
        return whole if abs(whole) <= MAX_INTEGER else None
    value = float(text)
    return value if abs(value) != float("inf") else None


def referred(value: str) -> str | None:
    """Return `name` for the value `{name}`, or None."""
    match = _REFERENCE.fullmatch(value)
    return match[1] if match else None


def is_constant(value: str) -> bool:
    """Return whether a value is a number, true, false or a list."""
    return value in _WORDS or number(value) is not None or value.startswith("[")


def is_illegal(text: str) -> bool:
    """Return whether a text holds a character that no XML file can hold."""
    return _ILLEGAL.search(text) is not None


def _is_global(value: str) -> bool:
    """Return whether a value names a variable of the blackboard above all trees."""
    return re.fullmatch(rf"\{{@{VARIABLE.pattern}\}}", value) is not None


def _json_quoted(text: str) -> str:
    return escaped(text, lambda c: json.dumps(c)[1:-1])


def _unquoted(value: str) -> str | None:
    if len(value) < 2 or value[0] != '"' or value[-1] != '"':
        return None
    try:
        text = json.loads(value)
    except ValueError:
        return None
    return text if isinstance(text, str) else None


def _is_braced(value: str) -> bool:
    return value.startswith("{") and value.endswith("}")


# ---- sorts of values -------------------------------------------------------------------------


@dataclass(frozen=True)
class Codec:
    """How values of one sort are read from an attribute, and written as one.

    `read` raises MisreadError. `write` returns None for a value that cannot be written.
    """

    read: Callable[[Attribute], LocatedValue]
    write: Callable[[Any], str | None]


def _misread(attribute: Attribute, message: str, hint: str | None = None) -> MisreadError:
    if _is_global(attribute.value):
        message, hint = "expected a variable of the tree", GLOBAL
    return MisreadError(
        ("BT-1203", attribute.value_at, f"{message}, got {quoted(attribute.value)}", hint)
    )


def _reference(attribute: Attribute) -> LocatedValue | None:
    name = referred(attribute.value)
    return None if name is None else located(f"${name}", attribute.value_at)


def _written_reference(value: Any, pattern: re.Pattern[str] = _VARIABLE) -> str | None:
    match = pattern.fullmatch(value) if isinstance(value, str) else None
    return f"{{{match[1]}}}" if match else None


def _read_variable(attribute: Attribute) -> LocatedValue:
    name = referred(attribute.value)
    if name is None:
        raise _misread(attribute, "expected a variable such as '{name}'")
    return located(name, attribute.value_at)


def _read_text(attribute: Attribute) -> LocatedValue:
    if (reference := _reference(attribute)) is not None:
        return reference
    if (inner := _unquoted(attribute.value)) is not None:
        return located(inner, attribute.value_at)
    if _is_braced(attribute.value):
        hint = "write a text in braces in double quotes, inside single quotes"
        raise _misread(attribute, "expected the name of a variable in '{...}'", hint)
    return plain_text(attribute)


def _written_text(text: str) -> str:
    reference = _written_reference(text) if text.startswith("$") else None
    is_plain = _unquoted(text) is None and not _is_braced(text) and not is_illegal(text)
    return reference or (text if is_plain else _json_quoted(text))


def _read_value(attribute: Attribute) -> LocatedValue:
    value = attribute.value
    constant = _WORDS[value] if value in _WORDS else number(value)
    if constant is not None:
        return located(constant, attribute.value_at)
    return (_read_list if value.startswith("[") else _read_text)(attribute)


def _written_value(value: Any) -> str:
    if not isinstance(value, str):
        return flow(value)
    return _json_quoted(value) if is_constant(value) else _written_text(value)


def _read_list(attribute: Attribute) -> LocatedValue:
    line, column = attribute.value_at
    try:
        data, place = compose(attribute.value, "")
    except InputError as error:
        usual = "a list is written as in YAML, such as [1.0, 0.5, 90]"
        raise MisreadError(
            *(
                (
                    diagnostic.code,
                    attribute.within(max(diagnostic.column, 1) - 1),
                    diagnostic.message,
                    diagnostic.hint or usual,
                )
                for diagnostic in error.diagnostics
            )
        ) from None
    return LocatedValue(data, _moved(place, (line, column + 1)))


def _read_times(attribute: Attribute, least: int = 1) -> LocatedValue:
    if (reference := _reference(attribute)) is not None:
        return reference
    value = number(attribute.value)
    if not isinstance(value, int) or value < least:
        hint = "repeating forever has no counterpart; give a number" if value == -1 else None
        expected = f"expected an integer of at least {least}, or a variable '{{name}}'"
        raise _misread(attribute, expected, hint)
    return located(value, attribute.value_at)


def _written_times(value: Any) -> str | None:
    return _written_reference(value) if isinstance(value, str) else str(value)


def _read_milliseconds(attribute: Attribute) -> LocatedValue:
    times = _read_times(attribute, least=0)
    value = times.data
    return LocatedValue(f"{value} / 1000" if isinstance(value, str) else value / 1000, times.place)


def _written_milliseconds(seconds: Any) -> str | None:
    if isinstance(seconds, str):
        if not is_quantity(seconds):
            return _written_reference(seconds, _THOUSANDTH)
        seconds = SECONDS.parse(seconds)
    if seconds * 1000 > _LARGEST_MSEC:
        return None
    whole = round(seconds * 1000)
    return str(whole) if whole / 1000 == seconds else None


def _read_number(attribute: Attribute) -> LocatedValue:
    value = number(attribute.value)
    return located(attribute.value if value is None else value, attribute.value_at)


def _read_names(attribute: Attribute) -> LocatedValue:
    return located([name.strip() for name in attribute.value.split(",")], attribute.value_at)


def _read_flow(attribute: Attribute) -> LocatedValue:
    try:
        return located(read_yaml(attribute.value).data, attribute.value_at)
    except InputError as error:
        first = error.diagnostics[0]
        raise MisreadError((first.code, attribute.value_at, first.message, None)) from None


def _read_constant(attribute: Attribute, word: str) -> LocatedValue:
    text = attribute.value
    if word == "text":
        return plain_text(attribute)
    if word == "list" and text.startswith("["):
        return _read_list(attribute)
    value: Any = _WORDS.get(text) if word == "bool" else None
    if word in ("number", "integer"):
        value = number(text)
    if value is None or (word == "integer" and isinstance(value, float)):
        raise _misread(attribute, f"expected a value of the type {LABELS[word]}")
    return located(float(value) if word == "number" else value, attribute.value_at)


def _written_constant(value: Any, word: str) -> str | None:
    if word == "text":
        return value if isinstance(value, str) else None
    if isinstance(value, str) or (word == "list") != isinstance(value, list):
        return None
    if word == "number":
        return repr(float(value)) if float(value) == value else None
    return flow(value)


def _text_constant(text: str) -> str | None:
    """Return the expression for a text, or None where it has both kinds of quotes."""
    return next((f"{mark}{text}{mark}" for mark in "'\"" if mark not in text), None)


def _read_given(attribute: Attribute, word: str) -> LocatedValue:
    if (reference := _reference(attribute)) is not None:
        return reference
    if word != "text":
        return _read_constant(attribute, word)
    constant = _text_constant(attribute.value)
    if constant is None:
        message = "a text with both kinds of quotes cannot be passed to a tree"
        raise MisreadError(("BT-1203", attribute.value_at, message, None))
    return located(constant, attribute.value_at)


def _written_given(value: Any, word: str) -> str | None:
    if not isinstance(value, str):
        return _written_constant(value, word)
    if value not in ("true", "false", "pi") and (reference := _written_reference(value)):
        return reference
    inner = value[1:-1]
    is_plain = inner and not _is_braced(inner)
    return inner if word == "text" and is_plain and _text_constant(inner) == value else None


AS_IT_IS = Codec(plain_text, str)
TEXT = Codec(_read_text, _written_text)
VALUE = Codec(_read_value, _written_value)
OUTPUT = Codec(_read_variable, "{{{}}}".format)
TIMES = Codec(_read_times, _written_times)
MILLISECONDS = Codec(_read_milliseconds, _written_milliseconds)
NUMBER = Codec(_read_number, str)
NAMES = Codec(_read_names, ", ".join)
FLOW = Codec(_read_flow, flow)


def constant(word: str) -> Codec:
    """Return how constants of one of our types are written as the default of a port."""
    return Codec(partial(_read_constant, word=word), partial(_written_constant, word=word))


def given(word: str) -> Codec:
    """Return how an expression is given to a port of one of our types."""
    return Codec(partial(_read_given, word=word), partial(_written_given, word=word))


# ---- diagnostics -----------------------------------------------------------------------------

HARMLESS = ("_description", "_uid", "_fullpath")
"""Attributes that editors write for themselves, and that mean nothing to a tree."""

_INSTEAD = {
    "_skipIf": "it is read below a Sequence or Fallback that has a child without it; else write "
    '<Precondition if=... else="SUCCESS">',
}


@dataclass
class Reporter:
    """Collects the diagnostics of one file."""

    source: XmlSource
    diagnostics: list[Diagnostic] = field(default_factory=list)

    def report(self, code: str, at: At, message: str, hint: str | None = None) -> None:
        """Note a diagnostic, once."""
        diagnostic = diagnostic_at(code, at, self.source.file, self.source.lines, message, hint)
        if len(self.diagnostics) < MOST_DIAGNOSTICS and diagnostic not in self.diagnostics:
            self.diagnostics.append(diagnostic)

    def value(self, attribute: Attribute, codec: Codec) -> LocatedValue:
        """Return the value of an attribute; note what is wrong with it."""
        try:
            return codec.read(attribute)
        except MisreadError as error:
            for diagnostic in error.diagnostics:
                self.report(*diagnostic)
            return located("", attribute.value_at)

    def take(self, attributes: dict[str, Attribute], name: str, at: At) -> Attribute | None:
        """Return an attribute that is needed, and leave it out of those that are still to read."""
        if name not in attributes:
            self.report("BT-1207", at, f"the attribute '{name}' is missing")
        return attributes.pop(name, None)

    def refuse(
        self, attributes: Iterable[Attribute], tag: str, known: tuple[str, ...], *silent: str
    ) -> None:
        """Note the attributes that an element does not take; `silent` ones it takes as well."""
        for attribute in attributes:
            name = attribute.name
            if name in known or name in silent or name in HARMLESS:
                continue
            if name.startswith("_"):
                nodes = "use nodes instead: ScriptCondition, Script, Precondition, WhileDoElse"
                message = f"the attribute {quoted(name)} has no counterpart"
                self.report("BT-1204", attribute.at, message, _INSTEAD.get(name, nodes))
            else:
                message = f"no attribute {quoted(name)} for {tag} (it takes: {listed(known)})"
                self.report("BT-1202", attribute.at, message, did_you_mean(name, known))
