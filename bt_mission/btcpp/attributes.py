"""Values with places, what an attribute says, and how a value is said as one.

`{name}` is the variable `$name`. A number, true, false and a list in `[...]` are themselves, and
anything else is a text. A text that would be read as something else stands in double quotes, as
in JSON.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Protocol

from bt_mission.btcpp.elements import Attribute
from bt_mission.btcpp.yaml_text import escaped, flow
from bt_mission.core.diagnostics import InputError, did_you_mean, listed, quoted
from bt_mission.core.yaml.composer import MAX_INTEGER, At, Place, compose

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
VARIABLE_NAME = re.compile(r"\$?([A-Za-z_][A-Za-z0-9_]*)")
"""An expression that is a variable and nothing else."""

_REFERENCE = re.compile(r"\{([A-Za-z_][A-Za-z0-9_]*)\}")
_VARIABLE = re.compile(r"\$([A-Za-z_][A-Za-z0-9_]*)")
_NUMBER = re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?")
_INTEGER = re.compile(r"[-+]?[0-9]+")
_ILLEGAL = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_WORDS = {"true": True, "false": False}


class FaultReport(Protocol):
    """Told of a fault: where, what, and what to do."""

    def __call__(self, at: At, message: str, hint: str | None = None) -> None:
        """Note it."""


# ---- values with places ----------------------------------------------------------------------


@dataclass(frozen=True)
class LocatedValue:
    """A value as a YAML file would hold it, and where it stands in the XML file."""

    data: Any
    place: Place


Entry = tuple[str, At, LocatedValue]
"""A key, where it stands, and its value."""


def located(data: Any, at: At) -> LocatedValue:
    """Return data that stands at one place, but for the values in it that have theirs."""
    match data:
        case LocatedValue():
            return data
        case dict():
            return mapping(at, [(key, at, located(value, at)) for key, value in data.items()])
        case list():
            items = [located(value, at) for value in data]
            place = Place(*at, parts=[one.place for one in items])
            return LocatedValue([one.data for one in items], place)
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
    """Return the value of an attribute as it is, so that columns in it can be told."""
    return LocatedValue(attribute.value, Place(*attribute.value_at, text=attribute.value))


def entry(attribute: Attribute) -> Entry:
    """Return an attribute as an entry: its name, its place, and its value as it is."""
    return attribute.name, attribute.at, plain_text(attribute)


def _moved(place: Place, at: At) -> Place:
    """Return a place within a text as a place in the file that the text begins at, on one line."""
    line, column = at
    parts: dict[str, Place] | list[Place] | None = None
    if isinstance(place.parts, dict):
        parts = {key: _moved(part, at) for key, part in place.parts.items()}
    elif isinstance(place.parts, list):
        parts = [_moved(part, at) for part in place.parts]
    keys = {key: (line, column + found[1] - 1) for key, found in (place.keys or {}).items()}
    return Place(
        line,
        column + place.column - 1,
        keys=keys if place.keys is not None else None,
        parts=parts,
        text=place.text,
    )


# ---- attributes that an element does not take ---------------------------------------------------


def refuse_attribute(
    attribute: Attribute, tag: str, known: Iterable[str], report: FaultReport
) -> None:
    """Report an attribute that an element does not take."""
    name = attribute.name
    if name.startswith("_"):
        report(attribute.at, f"the attribute {quoted(name)} has no counterpart", _instead(name))
        return
    message = f"no attribute {quoted(name)} for {tag} (it takes: {listed(known)})"
    report(attribute.at, message, did_you_mean(name, known))


def _instead(name: str) -> str:
    if name == "_description":
        return "use 'name', or a comment"
    if name == "_skipIf":
        return (
            "it is read below a Sequence or Fallback that has a child without it; else write "
            '<Precondition if=... else="SUCCESS">'
        )
    return "use nodes instead: ScriptCondition, Script, Precondition, WhileDoElse"


# ---- values of attributes -----------------------------------------------------------------------


def number(text: str) -> int | float | None:
    """Return the number that a text is, or None where it is none, or too large."""
    if not _NUMBER.fullmatch(text) or len(text) > 400:
        return None
    if _INTEGER.fullmatch(text):
        whole = int(text)
        return whole if abs(whole) <= MAX_INTEGER else None
    value = float(text)
    return value if abs(value) != float("inf") else None


def read_reference(attribute: Attribute) -> LocatedValue | None:
    """Return `$name` for the value `{name}`, or None."""
    found = _REFERENCE.fullmatch(attribute.value)
    return located(f"${found[1]}", attribute.value_at) if found else None


def referred(value: str) -> str | None:
    """Return `name` for the value `{name}`, or None."""
    found = _REFERENCE.fullmatch(value)
    return found[1] if found else None


def is_constant(value: str) -> bool:
    """Return whether a value is a number, true, false or a list."""
    return value in _WORDS or number(value) is not None or value.startswith("[")


def read_variable(attribute: Attribute, report: FaultReport) -> LocatedValue:
    """Return the name of the variable that an attribute such as `out_x="{name}"` holds."""
    found = read_reference(attribute)
    if found is None:
        message = f"expected a variable such as '{{name}}', got {quoted(attribute.value)}"
        report(attribute.value_at, message)
        return located("_", attribute.value_at)
    return located(found.data.removeprefix("$"), attribute.value_at)


def read_text(attribute: Attribute, report: FaultReport) -> LocatedValue:
    """Return the text that an attribute holds."""
    reference = read_reference(attribute)
    if reference is not None:
        return reference
    inner = _unquoted(attribute.value)
    if inner is not None:
        return located(inner, attribute.value_at)
    if _is_braced(attribute.value):
        got = quoted(attribute.value)
        message = f"expected the name of a variable in '{{...}}', got {got}"
        hint = "a text in braces is written in double quotes, within the others"
        report(attribute.value_at, message, hint)
        return located("", attribute.value_at)
    return plain_text(attribute)


def written_text(text: str) -> str:
    """Return the value of an attribute that `read_text` takes for this text."""
    is_plain = _unquoted(text) is None and not _is_braced(text) and not is_illegal(text)
    found = _VARIABLE.fullmatch(text)
    return VARIABLE.write(found[1]) if found else text if is_plain else _json_quoted(text)


def read_value(attribute: Attribute, report: FaultReport) -> LocatedValue:
    """Return the value that an attribute holds."""
    value = attribute.value
    found = _WORDS[value] if value in _WORDS else number(value)
    if found is not None:
        return located(found, attribute.value_at)
    return (read_list if value.startswith("[") else read_text)(attribute, report)


def written_value(value: Any) -> str:
    """Return the value of an attribute that `read_value` takes for this value."""
    if not isinstance(value, str):
        return flow(value)
    if is_constant(value):
        return _json_quoted(value)
    return written_text(value)


def read_list(attribute: Attribute, report: FaultReport) -> LocatedValue:
    """Return the list that an attribute holds."""
    line, column = attribute.value_at
    try:
        data, place = compose(attribute.value, "")
    except InputError as error:
        for fault in error.faults:
            hint = fault.hint or "a list is written as in YAML, such as [1.0, 0.5, 90]"
            report(attribute.within(max(fault.column, 1) - 1), fault.message, hint)
        return located("", (line, column + 1))
    return LocatedValue(data, _moved(place, (line, column + 1)))


@dataclass(frozen=True)
class Codec:
    """How values of one sort are read from an attribute, and written as one."""

    read: Callable[[Attribute, FaultReport], LocatedValue]
    write: Callable[[Any], str]


AS_IT_IS = Codec(lambda attribute, _: plain_text(attribute), str)
TEXT = Codec(read_text, written_text)
VALUE = Codec(read_value, written_value)
VARIABLE = Codec(read_variable, "{{{}}}".format)


def is_illegal(text: str) -> bool:
    """Return whether a text holds a character that no XML file can hold."""
    return _ILLEGAL.search(text) is not None


def _json_quoted(text: str) -> str:
    return escaped(text, lambda c: json.dumps(c)[1:-1])


def _unquoted(value: str) -> str | None:
    if len(value) < 2 or value[0] != '"' or value[-1] != '"':
        return None
    try:
        found = json.loads(value)
    except ValueError:
        return None
    return found if isinstance(found, str) else None


def _is_braced(value: str) -> bool:
    return value.startswith("{") and value.endswith("}")
