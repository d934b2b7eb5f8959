"""Goals that others sent, as lines, as objects, or drawn in place on a terminal."""

from __future__ import annotations

from typing import Any, Protocol, TextIO

from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from bt_mission.graph_tools.goal_lines import said
from bt_mission.graph_tools.interface_description import InterfaceDescription
from bt_mission.graph_tools.values import as_json, plain


class WatchView(Protocol):
    """Told of what becomes of goals; writes it when :meth:`flush` is called.

    Only there, outside of callbacks, a pipe that has closed may be noticed.
    """

    def state(self, goal: str, since_s: float, state: str, *, is_end: bool) -> None:
        """A goal came into a state, so many seconds after it was first seen."""

    def feedback(self, goal: str, since_s: float, message: Any) -> None:
        """Feedback of a goal came."""

    def flush(self) -> None:
        """Write what has come."""

    def close(self) -> None:
        """Nothing more will come."""


def watch_view(stream: TextIO, about: InterfaceDescription, *, json: bool) -> WatchView:
    """Drawn in place on a terminal, lines in a pipe, objects for programs."""
    if json:
        return WatchObjects(stream)
    console = Console(file=stream, highlight=False)
    if console.is_terminal and not console.is_dumb_terminal:
        return WatchPicture(console, about)
    return WatchLines(stream, about)


class WatchObjects:
    """An object a line: a state, or a feedback, with the goal's whole id."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._objects: list[dict[str, Any]] = []

    def state(self, goal: str, _since_s: float, state: str, *, is_end: bool) -> None:
        """Keep it for :meth:`flush`."""
        self._objects.append({"goal": goal, "state": state, "is_end": is_end})

    def feedback(self, goal: str, _since_s: float, message: Any) -> None:
        """Keep it for :meth:`flush`."""
        self._objects.append({"goal": goal, "feedback": plain(message)})

    def flush(self) -> None:
        """Write what has come."""
        objects, self._objects = self._objects, []
        for one in objects:
            print(as_json(one), file=self._stream, flush=True)

    def close(self) -> None:
        """Nothing to do."""


class WatchLines:
    """A line for each state, and for feedback that has changed."""

    def __init__(self, stream: TextIO, about: InterfaceDescription) -> None:
        self._stream = stream
        self._units = about.part("feedback").units()
        self._last: dict[str, str] = {}
        self._lines: list[str] = []

    def state(self, goal: str, since_s: float, state: str, *, is_end: bool) -> None:
        """Keep a line for :meth:`flush`."""
        self._lines.append(_line(goal, since_s, state))
        if is_end:
            self._last.pop(goal, None)

    def feedback(self, goal: str, since_s: float, message: Any) -> None:
        """Keep a line for :meth:`flush`, if something has changed."""
        text = said(message, self._units)
        if self._last.get(goal) != text:
            self._last[goal] = text
            self._lines.append(_line(goal, since_s, text))

    def flush(self) -> None:
        """Write what has come."""
        lines, self._lines = self._lines, []
        for line in lines:
            print(line, file=self._stream, flush=True)

    def close(self) -> None:
        """Nothing to do."""


class WatchPicture:
    """A line for each state, to stay; below them the newest feedback of goals under way."""

    def __init__(self, console: Console, about: InterfaceDescription) -> None:
        self._console = console
        self._units = about.part("feedback").units()
        self._lines: list[str] = []
        self._newest: dict[str, str] = {}
        self._is_stale = False
        self._live = Live(console=console, auto_refresh=False, transient=True)
        self._live.start()

    def state(self, goal: str, since_s: float, state: str, *, is_end: bool) -> None:
        """Keep a line for :meth:`flush`."""
        self._lines.append(_line(goal, since_s, state))
        if is_end:
            self._newest.pop(goal, None)
        self._is_stale = True

    def feedback(self, goal: str, since_s: float, message: Any) -> None:
        """Keep it as the newest of its goal."""
        self._newest[goal] = _line(goal, since_s, said(message, self._units))
        self._is_stale = True

    def flush(self) -> None:
        """Draw, if there is anything new."""
        if not self._is_stale:
            return
        self._is_stale = False
        rows = [Text(line, no_wrap=True, overflow="ellipsis") for line in self._newest.values()]
        self._live.update(Group(*rows), refresh=True)  # what is printed appears above it
        lines, self._lines = self._lines, []
        for line in lines:
            self._console.print(Text(line, no_wrap=True, overflow="ellipsis"))

    def close(self) -> None:
        """Leave the lines, and take the rest away."""
        self._live.stop()


def _line(goal: str, since_s: float, text: str) -> str:
    return f"{goal[:8]} {since_s:9.2f} s  {text}"
