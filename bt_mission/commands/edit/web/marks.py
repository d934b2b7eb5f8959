"""Diagnostics and nodes of a text, as the page shows them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from bt_mission.base.diagnostics import Diagnostic, InputError
from bt_mission.base.error_catalogue import catalogue
from bt_mission.base.yaml.composer import split_lines
from bt_mission.commands.edit.outline import outline
from bt_mission.commands.edit.spans import read_spans

MOST_MARKS = 100


def marks(diagnostics: Iterable[Diagnostic], text: str, path: Path) -> list[dict[str, Any]]:
    """Return diagnostics with offsets in a text; one of another file is at the start."""
    lines = split_lines(text)
    starts, at = [], 0
    for line in lines:
        starts.append(at)
        at += len(line) + 1
    notes: list[dict[str, Any]] = []
    for each in list(diagnostics)[:MOST_MARKS]:
        is_here = each.file == str(path) and 0 < each.line <= len(lines)
        start = end = 0
        if is_here:
            line = lines[each.line - 1]
            column = min(max(each.column - 1, 0), len(line))
            start = starts[each.line - 1] + column
            end = starts[each.line - 1] + _end_of_word(line, column)
        notes.append(
            {
                "from": start,
                "to": end,
                "line": each.line if is_here else 0,
                "severity": each.severity,
                "code": each.code,
                "message": each.message if is_here else f"{each.file}: {each.message}",
                "hint": each.hint or "",
            }
        )
    return notes


def _end_of_word(line: str, column: int) -> int:
    end = column
    while end < len(line) and (line[end].isalnum() or line[end] in "_$./-"):
        end += 1
    return max(end, min(column + 1, len(line)))


def boxes(text: str) -> list[dict[str, Any]] | None:
    """Return the nodes of a mission for a drawing; None if the text is not YAML."""
    try:
        root = read_spans(text)
    except InputError:
        return None
    return [box.as_row() for box in outline(root, text)]


def explanation(code: str) -> dict[str, str] | None:
    """Return the entry of an error code; None without one."""
    entry = catalogue().get(code)
    if entry is None:
        return None
    names = ("code", "title", "cause", "cure", "wrong", "right")
    return {name: getattr(entry, name) for name in names}
