"""Progress of long work: lines in place on a terminal, a line now and then elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Self, TextIO

from rich.live import Live
from rich.text import Text

from bt_mission.base.text import duration, escape_control
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.views.terminal.console import EscapingConsole

FRAME_S = 0.1
LINE_S = 10.0
"""Between two lines where there is no terminal, s."""

Remarks = tuple[Sequence[str], Sequence[str]]
"""The text after the line, and the lines below it."""


class ProgressDisplay:
    """How far work is, in one form: ``explore: 12 of 100 runs   3.2/s   27 s left   4 workers``.

    The rate counts from entering it on. A terminal shows the lines below, too; elsewhere the first
    of them is added to the line.

    Args:
        what: The work, such as the name of a mission.
        total: How much there is to do; None where that is not known.
        remarks: Called when it is shown.
        stream: Where it goes.
        unit: What is counted; empty where that is clear.
        done: How much was done earlier.
        plain: As in a pipe, on a terminal too.
        quiet: Show nothing.
    """

    def __init__(
        self,
        what: str,
        total: int | None,
        remarks: Callable[[], Remarks],
        stream: TextIO,
        *,
        unit: str = "",
        done: int = 0,
        plain: bool = False,
        quiet: bool = False,
    ) -> None:
        self._what, self._total, self._unit = what, total, unit
        self._done = self._before = done
        self._remarks = remarks
        self._stream = stream
        self._is_quiet = quiet
        self._console = EscapingConsole(stream)
        is_screen = self._console.is_terminal and not self._console.is_dumb_terminal
        self._is_plain = plain or not is_screen
        self._live: Live | None = None
        self._wall, self._since = Stopwatch(), Stopwatch()
        self._closing = ExitStack()

    def __enter__(self) -> Self:
        self._wall, self._since = Stopwatch(), Stopwatch()
        if not (self._is_plain or self._is_quiet):
            live = Live(console=self._console, auto_refresh=False, transient=True)
            self._live = self._closing.enter_context(live)
            live.update(Text("\n".join(self.lines())), refresh=True)
        return self

    def __exit__(self, *_: object) -> None:
        self._live = None
        self._closing.close()

    def show(self, done: int) -> None:
        """Show how much is done, where it is time."""
        self._done = done
        if self._is_quiet or self._since.elapsed_s < (LINE_S if self._is_plain else FRAME_S):
            return
        self._since = Stopwatch()
        if self._live is not None:
            self._live.update(Text("\n".join(self.lines())), refresh=True)
        elif self._is_plain:
            line = " ".join(line.strip() for line in self.lines()[:2])
            print(line, file=self._stream, flush=True)

    def lines(self) -> list[str]:
        """Return what a terminal shows."""
        notes, below = self._remarks()
        of_total = "" if self._total is None else f" of {self._total:,}"
        parts = [f"{self._what}: {self._done:,}{of_total} {self._unit}".rstrip()]
        here, elapsed_s = self._done - self._before, self._wall.elapsed_s
        if here and elapsed_s > 0:
            rate = here / elapsed_s
            parts.append(f"{rate:.3g}/s")
            if self._total is not None:
                parts.append(f"{duration((self._total - self._done) / rate)} left")
        return [escape_control(line) for line in ("   ".join((*parts, *notes)), *below)]
