"""Goals and requests as people type them: YAML, held against the shape of a message."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bt_mission.core.diagnostics import InputError
from bt_mission.core.yaml.document import read_text
from bt_mission.language.message_types import MessageShape, Shape, TypeMismatch, Unknowable, conform


def read_fields(text: str, shape: MessageShape, what: str) -> Mapping[str, Any]:
    """Read the fields of a message; an empty text leaves every field at its default.

    :param what: names the text in faults, such as ``goal``.
    :raises InputError: with every fault, each with its line and column in the text.
    """
    if not text.strip():
        return {}
    document = read_text(text, what)
    problems: list[TypeMismatch] = []
    if not isinstance(document.data, Mapping):
        fault = document.fault(
            (), f"expected fields of {shape.name}, such as {_example(shape)}", _names(shape)
        )
        raise InputError([fault])
    filled: Mapping[str, Any] = conform(shape, document.data, _no_expressions, problems.append)
    if problems:
        raise InputError(
            document.fault(one.path, one.message, one.hint, key=one.at_key) for one in problems
        )
    return filled


def read_value(text: str, shape: Shape) -> tuple[Any, str]:
    """Read the value of one field from YAML; gives it, and what is wrong with it if anything is."""
    try:
        value = read_text(text, "value").data
    except InputError as error:
        return None, error.faults[0].message
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
