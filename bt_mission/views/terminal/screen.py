"""Textual's way to a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from rich.cells import cell_len, set_cell_size
from rich.segment import Segment
from textual.app import App
from textual.color import Color
from textual.filter import LineFilter

from bt_mission.base.text import escape_control

Result = TypeVar("Result")


class EscapingFilter(LineFilter):
    """Escapes the text of a line and cuts it to its length, so that everything stays in place."""

    def apply(
        self,
        segments: list[Segment],
        background: Color,  # noqa: ARG002 - the signature is Textual's
    ) -> list[Segment]:
        """Return the segments with their text escaped."""
        return [self._escaped(segment) for segment in segments]

    def _escaped(self, segment: Segment) -> Segment:
        text, style, control = segment
        shown = escape_control(text)
        if control or shown == text:
            return segment
        return Segment(set_cell_size(shown, cell_len(text)), style, control)


class EscapingApp(App[Result]):
    """An application whose only control sequences are Textual's, whatever its widgets show."""

    def __init__(self, *, ansi_color: bool = False) -> None:
        super().__init__(ansi_color=ansi_color)
        self._escaping = EscapingFilter()

    def get_line_filters(self) -> Sequence[LineFilter]:
        """Return Textual's filters, and the one that escapes."""
        return [*super().get_line_filters(), self._escaping]
