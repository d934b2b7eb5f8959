"""Values for a mission's inputs from outside, `--set speed=0.15`, checked against the defaults."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from pydantic_core import PydanticCustomError

from bt_mission.base.diagnostics import (
    Diagnostic,
    InputError,
    describe,
    did_you_mean,
    listed,
    quoted,
)
from bt_mission.base.units import UNITS, converted
from bt_mission.base.yaml.document import read_text
from bt_mission.language.expressions.units import Measured, is_angle
from bt_mission.language.expressions.values import WORDS, Plain, Type, type_of
from bt_mission.language.nodes.fields import input_value, refusal

SET_OPTION = "--set"
"""Named instead of a file if a value from outside is wrong."""


def overridden(
    inputs: Mapping[str, Plain], given: Mapping[str, Plain]
) -> tuple[dict[str, Plain], list[Diagnostic]]:
    """Return the inputs with the given values in place, and the diagnostics of those.

    A value given as text is read as the default's type asks: `0.15` for a number, `[1, 2]` for
    a list, anything for a text. Whole numbers and others may replace each other.
    """
    values = dict(inputs)
    diagnostics = []
    for name, value in given.items():
        source = f"{name}={value}"
        if name not in inputs:
            message = f"unknown input {quoted(name)} (the mission's inputs: {listed(inputs)})"
            hint = did_you_mean(name, inputs)
            diagnostics.append(Diagnostic("BT-310", message, SET_OPTION, 1, 1, source, hint))
            continue
        wanted = _type_of(inputs[name])
        taken = _read(value) if isinstance(value, str) and wanted != "text" else value
        try:
            taken = _in_unit(inputs[name], taken)
        except PydanticCustomError as error:
            code, hint = (error.context or {})["code"], (error.context or {}).get("hint")
            at = (1, len(name) + 2)
            diagnostics.append(Diagnostic(code, error.message(), SET_OPTION, *at, source, hint))
            continue
        if _is_plain(taken) and _type_of(taken) == wanted:
            values[name] = taken
            continue
        message = f"input {quoted(name)} expects {WORDS[wanted]}, got {describe(value)}"
        diagnostics.append(Diagnostic("BT-310", message, SET_OPTION, 1, len(name) + 2, source))
    return values, diagnostics


def named_inputs(diagnostic: Diagnostic) -> Diagnostic:
    """Return a diagnostic of a value from Python, which has no place in a command."""
    if diagnostic.file != SET_OPTION:
        return diagnostic
    return replace(diagnostic, file="inputs", line=0, column=0, source="")


def _read(text: str) -> Any:
    """Return what a text means in YAML; the text itself where it means nothing there."""
    try:
        return read_text(text).data
    except InputError:
        return text


def _in_unit(default: Plain, value: Any) -> Any:
    """Return a value in the unit of the input that it is for.

    Raises:
        PydanticCustomError: Where the units do not fit.
    """
    if not isinstance(default, str) and isinstance(value, str | list) and _is_plain(value):
        value = input_value(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    unit = value.unit if isinstance(value, Measured) else ""
    if not isinstance(default, Measured):
        if unit and is_angle(unit):
            message = f"the default of the input has no unit, got {unit}"
            raise refusal(message, "write the number without a unit", code="BT-305")
        return value
    if unit and UNITS[unit][1] != UNITS[default.unit][1]:
        raise refusal(f"the input is in {default.unit}, got {unit}", code="BT-305")
    return Measured(converted(value, unit or default.unit, default.unit), default.unit)


def _is_plain(value: Any) -> bool:
    """Return whether a value may be one of an input, as `fields.plain` has it in a file."""
    if isinstance(value, list):
        return all(_is_plain(part) for part in value)
    return isinstance(value, str) or (isinstance(value, int | float) and math.isfinite(value))


def _type_of(value: object) -> Type | None:
    """Return the type of a value; here whole numbers are numbers like others."""
    kind = type_of(value)
    return "number" if kind == "integer" else kind
