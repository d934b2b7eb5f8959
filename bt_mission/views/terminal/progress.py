"""Progress of long work: a few lines in place on a terminal, a line now and then in a pipe."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TextIO

from rich.live import Live
from rich.text import Text

from bt_mission.core.terminal.console import EscapingConsole
from bt_mission.core.wall_clock import Stopwatch

FRAME_S = 0.1
LINE_S = 10.0
"""Between two lines where there is no terminal, s."""


@contextmanager
def shown_progress(
    lines: Callable[[], Sequence[str]], stream: TextIO, *, plain: bool = False, quiet: bool = False
) -> Iterator[Callable[[], None]]:
    """Show lines that change; gives what is to be called when they have.

    Args:
        lines: Gives what is to be shown now; in a pipe the first of it, at times.
        stream: Where it goes.
        plain: As in a pipe, on a terminal too.
        quiet: Show nothing.
    """
    console = EscapingConsole(stream)
    if quiet:
        yield lambda: None
    elif plain or not console.is_terminal or console.is_dumb_terminal:
        yield _Lines(lines, stream).show
    else:
        with Live(console=console, auto_refresh=False, transient=True) as live:
            frame = Stopwatch()

            def show() -> None:
                nonlocal frame
                if frame.elapsed_s >= FRAME_S:
                    live.update(Text("\n".join(lines())), refresh=True)
                    frame = Stopwatch()

            live.update(Text("\n".join(lines())), refresh=True)
            yield show


class _Lines:
    """Prints the first line at times."""

    def __init__(self, lines: Callable[[], Sequence[str]], stream: TextIO) -> None:
        self._lines = lines
        self._stream = stream
        self._since = Stopwatch()

    def show(self) -> None:
        if self._since.elapsed_s >= LINE_S:
            self._since = Stopwatch()
            print(
                " ".join(line.strip() for line in self._lines()[:2]), file=self._stream, flush=True
            )
