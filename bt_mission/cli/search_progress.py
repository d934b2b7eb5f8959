"""The line on standard error that says how far a search is."""

from __future__ import annotations

import sys
from collections.abc import Callable

from bt_mission.core.wall_clock import Stopwatch

ON_TERMINAL_S, ELSEWHERE_S = 0.2, 10.0
"""Seconds between two lines."""


class SearchProgress:
    """Shows how far a search is, and how fast it is."""

    def __init__(self) -> None:
        self._watch = Stopwatch()
        self._is_terminal = sys.stderr.isatty()
        self._next_s = 0.0

    def show(self, runs: int, line: Callable[[], str]) -> None:
        """Show a line, where it is time.

        Args:
            runs: Scenarios that were carried out.
        """
        elapsed_s = self._watch.elapsed_s
        if elapsed_s < self._next_s:
            return
        self._next_s = elapsed_s + (ON_TERMINAL_S if self._is_terminal else ELSEWHERE_S)
        rate = f", {runs / elapsed_s:.1f} runs a second" if elapsed_s > 1 else ""
        start, end = ("\r\033[K", "") if self._is_terminal else ("", "\n")
        print(f"{start}{line()}{rate}", end=end, file=sys.stderr, flush=True)

    def end(self) -> None:
        """Leave the line."""
        if self._is_terminal:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
