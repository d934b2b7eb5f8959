"""What the leaves of a run came to, as a table for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.cells import cell_len, set_cell_size

from bt_mission.views.terminal.marks import Marks, clean
from bt_mission.views.terminal.words import fit, text_of

if TYPE_CHECKING:
    from bt_mission.executive.leaf_statistics import LeafSummary

LONGEST_NAME = 28
MOST_ROWS = 20
"""Where there are more leaves, those that ran longest are shown."""


def leaf_table(leaves: Sequence[LeafSummary], width: int, marks: Marks) -> list[str]:
    """A line for each leaf that took time or did not succeed; none where none did."""
    telling = [one for one in leaves if one.running_s > 0 or set(one.outcomes) != {"success"}]
    longest = sorted(telling, key=lambda one: -one.running_s)[:MOST_ROWS]
    shown = [one for one in telling if one in longest]
    if not shown:
        return []
    has_distance = any(one.distance_m is not None for one in shown)
    rows = [["leaf", "runs", "time", *(["driven"] if has_distance else []), "outcomes"]]
    rows += [_row(one, marks, has_distance=has_distance) for one in shown]
    widths = [max(cell_len(row[at]) for row in rows) for at in range(len(rows[0]) - 1)]
    lines = []
    for name, *figures, outcomes in rows:
        line = f"  {_padded(name, widths[0])}"
        for figure, room in zip(figures, widths[1:], strict=True):
            line += f"  {figure:>{room}}"
        lines.append(text_of(fit([(f"{line}  {outcomes}", "")], width, marks)).rstrip())
    if len(telling) > len(shown):
        lines.append(f"  and {len(telling) - len(shown)} leaves that ran for less time")
    return lines


def _row(one: LeafSummary, marks: Marks, *, has_distance: bool) -> list[str]:
    name = clean(one.name, marks)
    if cell_len(name) > LONGEST_NAME:
        name = set_cell_size(name, LONGEST_NAME - 1) + marks.cut
    row = [name, str(one.runs), f"{one.running_s:.2f} s"]
    if has_distance:
        row.append("" if one.distance_m is None else f"{one.distance_m:.2f} m")
    counts = sorted(one.outcomes.items(), key=lambda pair: -pair[1])
    only = len(counts) == 1
    return [*row, ", ".join(what if only else f"{count} {what}" for what, count in counts)]


def _padded(text: str, width: int) -> str:
    return text + " " * (width - cell_len(text))
