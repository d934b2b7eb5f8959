"""The lines of a mission's log, numbered, so that a page gets those that it has not."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bt_mission.events.log import LogEntry
from bt_mission.views.web import encoding

LINES = 500
"""Lines that a page is told when it opens."""


class LogLines:
    """The newest lines. A log that has lost its newest lines, as in a replay, is told anew."""

    def __init__(self) -> None:
        self._lines: list[tuple[int, list[Any]]] = []
        """Each with the revision at which it came."""
        self._last: LogEntry | None = None
        self._reset_revision = 0

    def show(self, log: Sequence[LogEntry], start_ns: int, revision: int) -> bool:
        """Take a log in as it is now; gives whether it is another one than before."""
        if (log[-1] if log else None) == self._last:
            return False
        news: list[LogEntry] = []
        for entry in reversed(log):
            if entry == self._last or len(news) == LINES:
                break
            news.append(entry)
        else:
            self._lines.clear()
            self._reset_revision = revision
        self._lines += [(revision, encoding.log_entry(one, start_ns)) for one in reversed(news)]
        del self._lines[:-LINES]
        self._last = log[-1] if log else None
        return True

    def since(self, revision: int) -> dict[str, Any]:
        """The lines that came after a revision, and whether they replace those before."""
        found: list[list[Any]] = []
        for came, line in reversed(self._lines):
            if came <= revision:
                break
            found.append(line)
        is_new = self._reset_revision > revision
        if not found and not is_new:
            return {}
        return {"log": found[::-1], **({"log_is_new": True} if is_new else {})}
