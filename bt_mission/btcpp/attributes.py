"""What an attribute of a leaf says, and how a value is said as one.

`{name}` is the variable `$name`. A number, true, false and a list in `[...]` are themselves, and
anything else is a text. A text that would be read as something else stands in double quotes, as
in JSON.
"""

from __future__ import annotations

import json
import re
from typing import Any, Protocol

from bt_mission.btcpp import parts
from bt_mission.btcpp.elements import Attribute
from bt_mission.btcpp.parts import At, LocatedValue
from bt_mission.btcpp.yaml_text import escaped, flow
from bt_mission.core.diagnostics import Diagnostic, InputError, quoted
from bt_mission.core.yaml.composer import MAX_INTEGER, compose

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
    at = (attribute.value_line, attribute.value_column)
    return parts.scalar(f"${found[1]}", at) if found else None


def read_text(attribute: Attribute, report: FaultReport) -> LocatedValue:
    """Return the text that an attribute holds."""
    value = attribute.value
    at = (attribute.value_line, attribute.value_column)
    reference = read_reference(attribute)
    if reference is not None:
        return reference
    inner = _unquoted(value)
    if inner is not None:
        return parts.scalar(inner, at)
    if _is_braced(value):
        message = f"expected the name of a variable in '{{...}}', got {quoted(value)}"
        report(at, message, "a text in braces is written in double quotes, within the others")
        return parts.scalar("", at)
    return parts.text(value, attribute)


def read_value(attribute: Attribute, report: FaultReport) -> LocatedValue:
    """Return the value that an attribute holds."""
    value = attribute.value
    at = (attribute.value_line, attribute.value_column)
    if value in _WORDS:
        return parts.scalar(_WORDS[value], at)
    found = number(value)
    if found is not None:
        return parts.scalar(found, at)
    if value.startswith("["):
        return read_list(attribute, report)
    return read_text(attribute, report)


def read_list(attribute: Attribute, report: FaultReport) -> LocatedValue:
    """Return the list that an attribute holds."""
    line, column = attribute.value_line, attribute.value_column + 1
    try:
        data, place = compose(attribute.value, "")
    except InputError as error:
        for fault in error.faults:
            report(attribute.at(max(fault.column, 1) - 1), fault.message, _one_line(fault))
        return parts.scalar("", (line, column))
    return LocatedValue(data, parts.moved(place, line, column))


def _one_line(fault: Diagnostic) -> str:
    return fault.hint or "a list is written as in YAML, such as [1.0, 0.5, 90]"


def written_text(text: str) -> str:
    """Return the value of an attribute that `read_text` takes for this text."""
    found = _VARIABLE.fullmatch(text)
    if found:
        return f"{{{found[1]}}}"
    if _unquoted(text) is not None or _is_braced(text) or _ILLEGAL.search(text):
        return json_quoted(text)
    return text


def written_value(value: Any) -> str:
    """Return the value of an attribute that `read_value` takes for this value."""
    if not isinstance(value, str):
        return flow(value)
    if value in _WORDS or number(value) is not None or value.startswith("["):
        return json_quoted(value)
    return written_text(value)


def json_quoted(text: str) -> str:
    """Return a text in double quotes, with what cannot be shown escaped."""
    return escaped(text, lambda c: json.dumps(c)[1:-1])


def is_illegal(text: str) -> bool:
    """Return whether a text holds a character that no XML file can hold."""
    return _ILLEGAL.search(text) is not None


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
