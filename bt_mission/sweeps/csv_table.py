"""All rows of a sweep as one table for spreadsheets."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from typing import Any, TextIO

from bt_mission.core.text import escape_lines
from bt_mission.sweeps.row import ScenarioRow

_NESTED = ("parameters", "nature", "requirements")
_PLAIN = tuple(one.name for one in fields(ScenarioRow) if one.name not in _NESTED)
_FORMULA = re.compile(r"[=+\-@\t\r\n]")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)


def write_csv(rows: Callable[[], Iterable[ScenarioRow]], file: TextIO) -> None:
    """Write a line for each row, as RFC 4180 has it.

    Each parameter has a column ``parameter.NAME``, each quantity of nature ``nature.NAME``, each
    requirement ``verdict.NAME`` and ``margin.NAME``. Columns and rows have the same order for the
    same results.

    A text that a spreadsheet would take for a formula has an apostrophe before it: reasons may come
    from servers and missions of others. (OWASP, "CSV Injection".)

    Args:
        rows: Gives them from the first on, each time that it is called.
        file: Opened with ``newline=""``.
    """
    parameters, nature, requirements = _columns(rows())
    writer = csv.writer(file)
    writer.writerow(
        [
            *_PLAIN,
            *(_cell(f"parameter.{name}") for name in parameters),
            *(_cell(f"nature.{name}") for name in nature),
            *(_cell(f"{what}.{name}") for name in requirements for what in ("verdict", "margin")),
        ]
    )
    for row in rows():
        cells = [getattr(row, name) for name in _PLAIN]
        cells += [row.parameters.get(name) for name in parameters]
        cells += [row.nature.get(name) for name in nature]
        for name in requirements:
            one = row.requirements.get(name)
            cells += [one and one.verdict, one and one.margin]
        writer.writerow([_cell(one) for one in cells])


def _columns(rows: Iterable[ScenarioRow]) -> tuple[list[str], list[str], list[str]]:
    """Name all parameters, quantities of nature and requirements, as they come first."""
    parameters: dict[str, None] = {}
    nature: dict[str, None] = {}
    requirements: dict[str, None] = {}
    for row in rows:
        parameters |= dict.fromkeys(row.parameters)
        nature |= dict.fromkeys(row.nature)
        requirements |= dict.fromkeys(row.requirements)
    return list(parameters), list(nature), list(requirements)


def _cell(value: Any) -> Any:
    match value:
        case bool():
            return str(value).lower()
        case str():
            shown = escape_lines(value)
            is_formula = _FORMULA.match(value) and not _NUMBER.fullmatch(value)
            return f"'{shown}" if is_formula else shown
        case list() | tuple() | Mapping():
            return json.dumps(value) if value else ""
    return value
