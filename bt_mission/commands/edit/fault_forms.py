"""Faults as a form writes them, and the scenario file of a mission with faults."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.commands.edit.scalars import as_text
from bt_mission.scenarios.faults.faults import FAULTS
from bt_mission.scenarios.faults.located import fault_in_text
from bt_mission.scenarios.faults.parameters import Parameter
from bt_mission.scenarios.faults.planned import WORD

OUTCOMES = ("success", "failure", "any")
_NUMBERS = re.compile(r"[-+0-9.eE, ()]+")


_FIELDS = {
    "name": "fields",
    "form": "fields",
    "words": "fields of the message with their values, such as error_code=906",
    "text": "",
    "unit": "",
    "default": "",
    "options": [],
    "is_required": False,
}


class FaultFormError(BtMissionError):
    """A form that describes no fault."""

    code = "BT-701"


def fault_kinds() -> list[dict[str, Any]]:
    """Return the table of faults with the fields of each, for a form."""
    return [
        {
            "name": kind.name,
            "text": kind.text.strip(),
            "area": kind.area,
            "fields": [
                *(_field(parameter) for parameter in kind.optional.values()),
                *([_FIELDS] if kind.takes_fields else []),
            ],
        }
        for kind in FAULTS.values()
    ]


def _field(parameter: Parameter) -> dict[str, Any]:
    default = None if parameter.is_required or parameter.repeats else parameter.default
    return {
        "name": parameter.name,
        "form": parameter.form,
        "words": parameter.expected,
        "text": parameter.text,
        "unit": parameter.unit,
        "default": "" if default is None else str(default).lower(),
        "options": list(parameter.choices) or ["true", "false"] * (parameter.form == "flag"),
        "is_required": parameter.is_required,
    }


def fault_text(begins: str, name: str, values: Mapping[str, str]) -> dict[str, Any]:
    """Return a fault as text, and the place at which it stands on the map; None without one.

    Args:
        begins: When, such as `at 5` or `when speed > 0.1`.
        name: Of the fault.
        values: By the names of its fields, as they are written in a form.

    Raises:
        FaultFormError: With what is wrong.
    """
    kind = FAULTS.get(name)
    parts = [f"{begins}: {name}"]
    for key, value in values.items():
        if key == "fields" and kind is not None and kind.takes_fields:
            parts.append(value)
            continue
        parameter = None if kind is None else kind.optional.get(key)
        if parameter is None:
            raise FaultFormError(f"{name} takes no '{key}'")
        is_first = parameter.repeats or not (parameter.by_name or parameter.form == "flag")
        written = _written(parameter, value.strip())
        parts.append(written if is_first and parameter.is_required else f"{key} {written}")
    try:
        planned = fault_in_text(" ".join(parts))
        planned.make()
    except InputError as error:
        raise FaultFormError(error.diagnostics[0].message) from None
    place = planned.arguments.get("at")
    return {"text": planned.text, "at": list(place) if isinstance(place, tuple) else None}


def _written(parameter: Parameter, value: str) -> str:
    if parameter.form == "numbers" and _NUMBERS.fullmatch(value):
        return f"({value.strip('()')})"
    if parameter.form in ("text", "anything") and not WORD.fullmatch(value):
        return "'" + value.replace("'", "") + "'"
    return value


def scenario_text(title: str, mission: str, faults: Sequence[str], outcome: str) -> str:
    """Return a scenario file: a mission with faults, and the result that is expected of it."""
    lines = [f"scenario: {as_text(title)}", f"mission: {as_text(mission)}", "faults:"]
    lines += [f"  - {as_text(fault)}" for fault in faults]
    return "\n".join([*lines, f"expect: {{outcome: {outcome}, orphaned_goals: any}}"]) + "\n"
