"""The views of a run, and which one fits an output."""

from __future__ import annotations

import sys
from typing import Self, TextIO

from rich.console import Console

from bt_mission.core.wall_clock import Stopwatch
from bt_mission.executive.executive import Change
from bt_mission.sessions.session import Session, View
from bt_mission.views.terminal.live import LiveTree
from bt_mission.views.terminal.plain import PlainLines


def view_for(stream: TextIO, *, plain: bool, quiet: bool) -> View:
    """A live tree on a terminal, plain lines in a pipe, nothing for ``--json``."""
    if quiet:
        return Quiet()
    console = Console(file=stream)
    if plain or not console.is_terminal or console.is_dumb_terminal:
        return Plain(stream)
    return Live(console)


class Quiet:
    """Shows nothing; what the mission says goes to standard error."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def open(self, session: Session, wall: Stopwatch, /) -> None:
        """Nothing to show."""

    def on_change(self, change: Change) -> None:
        """Nothing to show."""

    def refresh(self) -> None:
        """Nothing to show."""

    def say(self, text: str) -> None:
        """Pass on what the mission says."""
        print(text, file=sys.stderr)


class Plain(Quiet):
    """A line for each leaf that starts or ends."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._lines: PlainLines | None = None
        self._session: Session | None = None

    def open(self, session: Session, _wall: Stopwatch, /) -> None:
        """Say what is run."""
        self._session = session
        self._lines = PlainLines(self._stream, lambda: session.start_ns)
        print(_title(session), file=self._stream, flush=True)

    def on_change(self, change: Change) -> None:
        """Show a change."""
        if self._lines:
            self._lines.on_change(change)

    def say(self, text: str) -> None:
        """Show what the mission says."""
        if self._lines and self._session:
            self._lines.say(self._session.now_ns, text)


class Live(Quiet):
    """The tree, drawn again and again."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._tree: LiveTree | None = None

    def __exit__(self, *details: object) -> None:
        if self._tree:
            self._tree.__exit__(*details)

    def open(self, session: Session, wall: Stopwatch, /) -> None:
        """Begin to draw."""

        def header() -> str:
            virtual_s = (session.now_ns - session.start_ns) / 1e9
            factor = virtual_s / wall.elapsed_s if wall.elapsed_s > 0 else 0.0
            status = session.executive.status
            return f"{_title(session)}   {virtual_s:.1f} s   {factor:.0f} x real time   {status}"

        self._tree = LiveTree(self._console, session.executive, header)
        self._tree.__enter__()

    def refresh(self) -> None:
        """Draw, if it is time."""
        if self._tree:
            self._tree.refresh()

    def say(self, text: str) -> None:
        """Show what the mission says."""
        if self._tree:
            self._tree.say(text)


def _title(session: Session) -> str:
    mission = session.mission
    where = f" in {mission.world}" if mission.world else ""
    return f"{mission.name}{where} ({mission.robot}, seed {mission.seed})"
