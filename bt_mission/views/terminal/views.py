"""The views of a run, and which one fits an output: a live tree, plain lines, or nothing."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable
from typing import Self, TextIO

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.text import Text

from bt_mission.behaviours.action_leaf import ActionLeaf
from bt_mission.behaviours.leaves import progress_of
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.events.log import STYLES
from bt_mission.executive.executive import Executive
from bt_mission.executive.status import Change
from bt_mission.sessions.session import Session, View
from bt_mission.views.terminal.lines import PlainLines
from bt_mission.views.terminal.marks import bar, marks_for

FRAME_S = 0.1
BAR_WIDTH = 12
LOG_LINES = 4


def view_for(stream: TextIO, *, plain: bool, quiet: bool) -> View:
    """A live tree on a terminal, plain lines in a pipe, nothing for ``--json``."""
    if quiet:
        return Quiet()
    console = Console(file=stream)
    if plain or not console.is_terminal or console.is_dumb_terminal:
        return PlainView(stream)
    return LiveView(console)


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


class PlainView(Quiet):
    """A line for each leaf that starts or ends, and for each change of a pause."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._pause = ""
        self._session: Session | None = None
        self._lines = PlainLines(stream, lambda: self._session.start_ns if self._session else 0)

    def open(self, session: Session, _wall: Stopwatch, /) -> None:
        """Say what is run."""
        self._session = session
        print(_title(session), file=self._stream, flush=True)

    def on_change(self, change: Change) -> None:
        """Show a change."""
        self._lines.on_change(change)

    def refresh(self) -> None:
        """Tell that the mission is paused, and which of its goals are still under way."""
        if self._session is None:
            return
        executive = self._session.executive
        pause = "" if executive.paused is None else f"mission paused  {executive.explanation}"
        if pause != self._pause:
            self._pause = pause
            self.say(pause or f"mission {executive.state}")

    def say(self, text: str) -> None:
        """Show what the mission says."""
        if self._session:
            self._lines.say(self._session.now_ns, text)


class LiveView(Quiet):
    """The tree, drawn again and again, at most ten times a second."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._tree: LiveTree | None = None
        self._watch = Stopwatch()
        self._next_frame_s = 0.0
        self._live = Live(
            console=console, auto_refresh=False, transient=False, vertical_overflow="crop"
        )

    def __exit__(self, *_: object) -> None:
        if self._tree:
            self._live.update(self._tree.render(), refresh=True)
            self._live.stop()

    def open(self, session: Session, wall: Stopwatch, /) -> None:
        """Begin to draw."""

        def header() -> str:
            virtual_s = (session.now_ns - session.start_ns) / 1e9
            factor = virtual_s / wall.elapsed_s if wall.elapsed_s > 0 else 0.0
            executive = session.executive
            state = ": ".join(filter(None, (executive.state, executive.explanation)))
            return f"{_title(session)}   {virtual_s:.1f} s   {factor:.0f} x real time   {state}"

        self._tree = LiveTree(self._console, session.executive, header)
        self._live.start()

    def refresh(self) -> None:
        """Draw, if the last frame is old enough."""
        if self._tree and self._watch.elapsed_s >= self._next_frame_s:
            self._next_frame_s = self._watch.elapsed_s + FRAME_S
            self._live.update(self._tree.render(), refresh=True)

    def say(self, text: str) -> None:
        """Show what the mission says."""
        if self._tree:
            self._tree.said.append(text)


def _title(session: Session) -> str:
    mission = session.mission
    where = f" in {mission.world}" if mission.world else ""
    return f"{mission.name}{where} ({mission.robot}, seed {mission.seed})"


class LiveTree:
    """The picture of a running mission.

    Args:
        console: A terminal.
        executive: Whose tree to draw.
        header: Gives the line above the tree.
    """

    def __init__(self, console: Console, executive: Executive, header: Callable[[], str]) -> None:
        self.said: deque[str] = deque(maxlen=LOG_LINES)
        """What the mission said last; stands below the tree."""
        self._console = console
        self._executive = executive
        self._header = header
        self._marks = marks_for(console.encoding)

    def render(self) -> RenderableType:
        """The whole picture: header, tree, what was said."""
        rows = list(self._rows(self._executive.root, ""))
        room = max(self._console.height - 3 - len(self.said), 1)
        said = [Text(f"  {line}", style="italic", no_wrap=True) for line in self.said]
        return Group(
            Text(self._header(), style="bold", no_wrap=True, overflow="ellipsis"),
            *_window(rows, room),
            *said,
        )

    def _rows(self, node: Behaviour, indent: str) -> list[tuple[Status, Text]]:
        rows = [(node.status, self._row(node, indent))]
        for child in node.children:
            rows += self._rows(child, indent + "  ")
        return rows

    def _row(self, node: Behaviour, indent: str) -> Text:
        row = Text(no_wrap=True, overflow="ellipsis")
        row.append(
            f"{indent}{self._marks.status[node.status]} {node.name}", style=STYLES[node.status]
        )
        if (progress := progress_of(node)) is not None:
            value, limit = progress.value, progress.limit
            drawn = bar(value, limit, BAR_WIDTH, self._marks)
            row.append(f"  {drawn} {value:.4g} of {limit:.4g}", style="cyan")
        was_halted = isinstance(node, ActionLeaf) and node.was_halted
        if node.feedback_message and (node.status is not Status.INVALID or was_halted):
            row.append(f"  {node.feedback_message}", style="dim")
        return row


def _window(rows: list[tuple[Status, Text]], room: int) -> list[Text]:
    """As many rows as fit, with the deepest running one in sight."""
    if len(rows) <= room:
        return [text for _, text in rows]
    running = [i for i, (status, _) in enumerate(rows) if status is Status.RUNNING]
    focus = running[-1] if running else 0
    first = min(max(focus - room // 2, 0), len(rows) - room)
    return [text for _, text in rows[first : first + room]]
