"""Messages as plain values, these as text for people and programs, and typed text as values."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml  # type: ignore[import-untyped]

from bt_mission.base.diagnostics import InputError
from bt_mission.base.stamps import NS
from bt_mission.base.text import escape_control
from bt_mission.base.yaml.document import read_text
from bt_mission.language.message_types import MessageShape, Shape, TypeMismatch, Unknowable, conform

SHOWN_ITEMS = 16
"""Items of a list that are shown; a scan has hundreds, an image a million."""

SHOWN_CHARACTERS = 2_000
"""Characters of one text that are shown."""

_FLOAT32 = re.compile(r"\bfloat\b")  # its name in generated classes; the other is double
MARK = "items_that_are_not_shown_"
_MARKED = re.compile(rf"(?:,\s+|- )?{MARK}(\d+)(\]?)")
_NOT_NUMBERS = {math.inf: "Infinity", -math.inf: "-Infinity"}


@dataclass(frozen=True)
class Cut:
    """Replaces the items of a list that are not shown; their number is `left`."""

    left: int


def plain(value: Any, most: int | None = None) -> Any:
    """Return a message, or a field of one, as dicts, lists, numbers and texts.

    A float32 becomes the shortest decimal that is the same float32: 0.1, not 0.10000000149.

    Args:
        most: Items of a list that are kept; a :class:`Cut` replaces the rest.
    """
    if hasattr(value, "get_fields_and_field_types"):
        types = value.get_fields_and_field_types()
        return {name: _field(getattr(value, name), type_, most) for name, type_ in types.items()}
    if isinstance(value, bytes) and len(value) == 1:
        return value[0]
    if isinstance(value, str | bool | int | float):
        return value
    if hasattr(value, "tolist") and not hasattr(value, "__len__"):
        return value.tolist()
    kept = value if most is None else value[:most]
    items = kept.tolist() if hasattr(kept, "tolist") else [plain(item, most) for item in list(kept)]
    return _with_cut(items, value)


def _field(value: Any, type_: str, most: int | None) -> Any:
    if not _FLOAT32.search(type_):
        return plain(value, most)
    if isinstance(value, float):
        return float(str(np.float32(value)))
    kept = np.asarray(value if most is None else value[:most], np.float32).astype(str)
    return _with_cut(kept.astype(float).tolist(), value)


def _with_cut(items: list[Any], whole: Any) -> list[Any]:
    left = len(whole) - len(items)
    return [*items, Cut(left)] if left else items


def short(value: Any) -> str:
    """Return a plain value on one line: numbers to six digits, nested ones in braces."""
    match value:
        case bool():
            return "true" if value else "false"
        case float():
            return f"{value:.6g}"  # float32 brings no more
        case int():
            return str(value)
        case str():
            cut = value if len(value) <= SHOWN_CHARACTERS else value[:SHOWN_CHARACTERS] + "..."
            return escape_control(cut) if cut else "''"
        case Cut():
            return f"... {value.left} more"
        case Mapping():
            return "{" + ", ".join(f"{name} {short(part)}" for name, part in value.items()) + "}"
    return "[" + ", ".join(short(part) for part in value) + "]"


def flat(value: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Return the fields of a message by dotted names; a time or duration is one, in seconds."""
    for name, part in value.items():
        if isinstance(part, Mapping) and set(part) == {"sec", "nanosec"}:
            yield prefix + name, part["sec"] + part["nanosec"] / NS
        elif isinstance(part, Mapping) and part:
            yield from flat(part, f"{prefix}{name}.")
        else:
            yield prefix + name, part


class _ValueDumper(yaml.SafeDumper):  # type: ignore[misc]  # PyYAML has no types
    """Writes lists of numbers on one line, and the number of omitted items."""


def _write_list(dumper: _ValueDumper, items: list[Any]) -> yaml.Node:
    is_flat = all(isinstance(item, int | float | Cut) for item in items)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", items, flow_style=is_flat)


def _write_cut(dumper: _ValueDumper, cut: Cut) -> yaml.Node:
    return dumper.represent_scalar("tag:yaml.org,2002:str", f"{MARK}{cut.left}")


def _write_text(dumper: _ValueDumper, text: str) -> yaml.Node:
    # PyYAML does not escape all that reverse the direction of text; as_yaml() does.
    is_plain = escape_control(text.replace("\n", "")) == text.replace("\n", "")
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=None if is_plain else '"')


def _write_float(dumper: _ValueDumper, value: float) -> yaml.Node:
    if math.isfinite(value):
        return dumper.represent_scalar("tag:yaml.org,2002:float", repr(value))
    return dumper.represent_float(value)


_ValueDumper.add_representer(list, _write_list)
_ValueDumper.add_representer(Cut, _write_cut)
_ValueDumper.add_representer(float, _write_float)
_ValueDumper.add_representer(str, _write_text)


def as_yaml(value: Any) -> str:
    """Plain values as YAML, with everything unprintable escaped."""
    text: str = yaml.dump(
        value,
        Dumper=_ValueDumper,
        sort_keys=False,
        allow_unicode=True,
        width=100,
        default_flow_style=False,
    )
    text = "\n".join(escape_control(line) for line in text.removesuffix("...\n").split("\n"))
    return _MARKED.sub(lambda match: f"{match[2] or ''}  # {match[1]} more", text)


def as_json(value: Any) -> str:
    """Return plain values as one line of JSON.

    JSON has only finite numbers: others are the texts "NaN", "Infinity" and "-Infinity".
    """
    return json.dumps(_finite(value), allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        return _NOT_NUMBERS.get(value, "NaN")
    if isinstance(value, Mapping):
        return {name: _finite(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(part) for part in value]
    return value


def read_fields(text: str, shape: MessageShape, what: str) -> Mapping[str, Any]:
    """Read the fields of a message; an empty text leaves every field at its default.

    Args:
        what: The name of the text in errors, such as ``goal``.

    Raises:
        InputError: With every error, each with its line and column in the text.
    """
    if not text.strip():
        return {}
    document = read_text(text, what)
    problems: list[TypeMismatch] = []
    if not isinstance(document.data, Mapping):
        wrong = document.diagnostic(
            "BT-503",
            (),
            f"expected fields of {shape.name}, such as {_example(shape)}",
            _names(shape),
        )
        raise InputError([wrong])
    filled: Mapping[str, Any] = conform(shape, document.data, _no_expressions, problems.append)
    if problems:
        raise InputError(
            document.diagnostic(
                problem.code, problem.path, problem.message, problem.hint, key=problem.at_key
            )
            for problem in problems
        )
    return filled


def read_value(text: str, shape: Shape) -> tuple[Any, str]:
    """Read the value of one field from YAML. Return it, and the error, if any."""
    try:
        value = read_text(text, "value").data
    except InputError as error:
        return None, error.diagnostics[0].message
    problems: list[TypeMismatch] = []
    value = conform(shape, value, _no_expressions, problems.append)
    if not problems:
        return value, ""
    first = problems[0]
    place = ".".join(str(part) for part in first.path)
    return None, f"{place}: {first.message}" if place else first.message


def _no_expressions(*_: object) -> Any:
    raise Unknowable


def _example(shape: MessageShape) -> str:
    name = next(iter(shape.fields), "")
    return f"'{name}: ...'" if name else "'{}'"


def _names(shape: MessageShape) -> str:
    return f"its fields: {', '.join(shape.fields) or 'none'}"
