"""A part of the screen: a rule with a title, and rows below it.

Each style says by weight or order, too, what it says by colour.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from py_trees.common import Status
from rich.segment import Segment
from rich.style import Style
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from bt_mission.executive.events.log import STYLES as STATUS_LOOKS
from bt_mission.views.terminal.marks import Marks, Span, fit

STYLES: Mapping[str, Style] = {
    "": Style(),
    "running": Style.parse(STATUS_LOOKS[Status.RUNNING]),
    "success": Style.parse(STATUS_LOOKS[Status.SUCCESS]),
    "failure": Style.parse(STATUS_LOOKS[Status.FAILURE]),
    "idle": Style.parse(STATUS_LOOKS[Status.INVALID]),
    "title": Style(bold=True),
    "words": Style(dim=True),
    "time": Style(),
    "bar": Style(color="cyan"),
    "chosen": Style(bold=True, reverse=True),
    "folded": Style(color="magenta"),
    "breakpoint": Style(color="red", bold=True),
    "paused": Style(color="yellow", bold=True, reverse=True),
    "rule": Style(dim=True),
    "rule title": Style(bold=True),
    "key": Style(bold=True),
    "notice": Style(color="yellow", bold=True),
    "wall": Style(),
    "trail": Style(color="green"),
    "other": Style(color="magenta"),
    "scan": Style(color="yellow", bold=True),
    "waypoint": Style(color="magenta", bold=True),
    "zone": Style(color="yellow", dim=True),
    "robot": Style(color="cyan", bold=True, reverse=True),
}


class Pane(Widget):
    """Shows rows that it is given; only those that have changed are drawn again.

    Args:
        marks: The terminal's signs.
        has_rule: Has it a title?
    """

    DEFAULT_CSS = "Pane { background: ansi_default; color: ansi_default; }"

    def __init__(self, marks: Marks, *, has_rule: bool = True, **options: Any) -> None:
        super().__init__(**options)
        self._marks = marks
        self._has_rule = has_rule
        self._lines: list[list[Span]] = []

    @property
    def room(self) -> int:
        """How many rows fit."""
        return max(self.size.height - self._has_rule, 0)

    def show(self, rows: list[list[Span]], title: str = "", right: str = "") -> None:
        """Show these rows.

        Args:
            right: What stands at the right of the title.
        """
        lines = list(rows)
        if self._has_rule:
            lines.insert(0, rule(title, right, self.size.width, self._marks))
        height = self.size.height
        before, self._lines = self._lines, lines
        for y in range(min(max(len(before), len(lines)), height)):
            if before[y : y + 1] != lines[y : y + 1]:
                self.refresh(Region(0, y, self.size.width, 1))

    def render_line(self, y: int) -> Strip:
        """One line of the widget."""
        if y >= len(self._lines):
            return Strip.blank(self.size.width)
        return strip(self._lines[y], self.size.width, self._marks)


def strip(spans: list[Span], width: int, marks: Marks) -> Strip:
    """Spans as a line of a widget, cut and filled to its width."""
    segments = [Segment(text, STYLES[style]) for text, style in fit(spans, width, marks)]
    return Strip(segments).extend_cell_length(width)


def rule(title: str, right: str, width: int, marks: Marks) -> list[Span]:
    """The line above a panel: its title, and what stands at its right end if there is room."""
    spans: list[Span] = [(f"{marks.rule} ", "rule"), (title, "rule title"), (" ", "rule")]
    room = width - 3 - len(title)
    if right and room > len(right) + 4:
        return [
            *spans,
            (marks.rule * (room - len(right) - 3), "rule"),
            (f" {right} ", "words"),
            (marks.rule, "rule"),
        ]
    return [*spans, (marks.rule * max(room, 0), "rule")]
