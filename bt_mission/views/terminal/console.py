"""Rich's way to a terminal."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TextIO

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from bt_mission.base.text import escape_lines, escape_uncoloured
from bt_mission.views.terminal.streams import unescaped


class EscapingConsole(Console):
    """A console whose only control sequences are Rich's own.

    Args:
        file: The stream to write to.
        options: Others of Rich.
    """

    def __init__(self, file: TextIO, **options: Any) -> None:
        super().__init__(file=unescaped(file), highlight=False, markup=False, **options)

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """Render as Rich does, with the text of every segment escaped."""
        for text, style, control in super().render(renderable, options):
            yield Segment(text if control else escape_lines(text), style, control)


def coloured(line: str) -> Text:
    """Return a line that another program has written, with its colours and escaped otherwise."""
    return Text.from_ansi(escape_uncoloured(line))
