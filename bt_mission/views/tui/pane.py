"""A part of the screen: a rule with a title, and rows below it."""

from __future__ import annotations

from typing import Any

from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from bt_mission.views.terminal.marks import Marks
from bt_mission.views.terminal.words import Span
from bt_mission.views.tui.look import rule, strip


class Pane(Widget):
    """Shows rows that it is given; only those that have changed are drawn again.

    :param marks: the terminal's signs.
    :param has_rule: has it a title?
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

        :param right: what stands at the right of the title.
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
