"""Rows of results as they are read: each column checked, as the file may come from others."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, get_args

from bt_mission.core.nature import BY_NAME
from bt_mission.scenarios.cause import CauseKind
from bt_mission.sweeps.row import RequirementMargin, RowOutcome, ScenarioRow

JSON = ("parameters", "faults", "nature", "requirements")
"""Columns that hold JSON."""

DEEPEST = 8
"""Lists and mappings within each other, in the value of a parameter."""

_VERDICTS = ("holds", "violated", "open", "unknown")


class RowError(ValueError):
    """A row that is broken; it names the column."""


def row_of_columns(found: Mapping[str, Any]) -> ScenarioRow:
    """Return a row of its columns.

    Raises:
        RowError: With the first column that is broken.
    """
    made = {name: _parsed(name, value) if name in JSON else value for name, value in found.items()}
    for one in fields(ScenarioRow):
        is_valid = _VALID.get(one.name) or _BY_TYPE[str(one.type)]
        if not is_valid(made[one.name]):
            raise RowError(f"column '{one.name}': {_short(found[one.name])} is invalid")
    margins = made["requirements"].items()
    made["requirements"] = {name: RequirementMargin(**one) for name, one in margins}
    made["faults"] = tuple(made["faults"])
    made["passed"] = bool(made["passed"])
    row = ScenarioRow(**made)
    is_violated = any(one.verdict == "violated" for one in row.requirements.values())
    if row.passed != (row.cause_kind == "") or (row.cause_kind == "violated" and not is_violated):
        raise RowError(f"column 'cause_kind': '{row.cause_kind}' contradicts the other columns")
    return row


def _parsed(name: str, text: Any) -> Any:
    try:
        return json.loads(text)
    except (TypeError, ValueError, RecursionError):
        raise RowError(f"column '{name}': {_short(text)} is not JSON") from None


def _short(value: Any, most: int = 60) -> str:
    text = repr(value)
    return text if len(text) <= most else f"{text[: most - 1]}…"


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _is_number(value: Any) -> bool:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return is_number and math.isfinite(value)


def _or_none(is_valid: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda value: value is None or is_valid(value)


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _digits(most: str) -> Callable[[Any], bool]:
    """Return what tells whether a value is hexadecimal digits, of so many."""
    pattern = re.compile(f"[0-9a-f]{most}")
    return lambda value: _is_text(value) and pattern.fullmatch(value) is not None


def _is_plain(value: Any, deep: int = DEEPEST) -> bool:
    match value:
        case list():
            return deep > 0 and all(_is_plain(one, deep - 1) for one in value)
        case dict():
            return deep > 0 and all(_is_plain(one, deep - 1) for one in value.values())
    return value is None or isinstance(value, str | bool) or _is_number(value)


def _is_nature(value: Any) -> bool:
    return isinstance(value, dict) and all(
        name in BY_NAME and _is_number(number) for name, number in value.items()
    )


def _are_margins(value: Any) -> bool:
    return isinstance(value, dict) and all(map(_is_margin, value.values()))


def _is_margin(value: Any) -> bool:
    names = {one.name for one in fields(RequirementMargin)}
    return (
        isinstance(value, dict)
        and set(value) == names
        and value["verdict"] in _VERDICTS
        and _is_text(value["unit"])
        and all(
            value[name] is None or isinstance(value[name], int | float) for name in ("margin", "at")
        )
    )


_VALID: Mapping[str, Callable[[Any], bool]] = {
    "id": _digits("{1,64}"),
    "sample": _digits("{0,16}"),
    "coverage": _digits("*"),
    "outcome": lambda value: value in get_args(RowOutcome),
    "cause_kind": lambda value: value == "" or value in get_args(CauseKind),
    "passed": lambda value: value in (0, 1),
    "parameters": lambda value: isinstance(value, dict) and _is_plain(value),
    "faults": lambda value: isinstance(value, list) and all(map(_is_text, value)),
    "nature": _is_nature,
    "requirements": _are_margins,
}
"""Of columns, by name; the others go by their type."""

_BY_TYPE: Mapping[str, Callable[[Any], bool]] = {
    "int": _is_whole,
    "float": _is_number,
    "str": _is_text,
    "int | None": _or_none(_is_whole),
    "float | None": _or_none(_is_number),
}
