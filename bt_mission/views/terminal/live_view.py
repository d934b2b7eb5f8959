"""The views of a run, and the choice by output: a live tree, plain lines, or nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from functools import partial
from itertools import islice
from typing import TextIO

from py_trees.common import Status
from rich.cells import cell_len
from rich.console import Console, ConsoleDimensions, Group
from rich.live import Live
from rich.text import Text

from bt_mission.base.clock_watch import told_by
from bt_mission.base.stamps import NS
from bt_mission.base.text import escape_control, lines_of, seconds
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.behaviours.leaves import LeafProgress, progress_of
from bt_mission.executive.events.events import Event, NodeChanged
from bt_mission.executive.events.log import STYLES, speech_of
from bt_mission.executive.events.mission_state import NodeEnd
from bt_mission.executive.executive import Executive
from bt_mission.sessions.session import MissionRun, Session
from bt_mission.sessions.view import View
from bt_mission.views.terminal.console import EscapingConsole, coloured
from bt_mission.views.terminal.lines import ControlLines, PlainLines, timed
from bt_mission.views.terminal.marks import bar, clean, marks_for
from bt_mission.views.terminal.output_capture import OutputCapture
from bt_mission.views.terminal.tree_rows import progress_figures

FRAME_S = 0.1
BAR_WIDTH = 12
ABOVE = 4
"""Rows of a screen that stay free of the trees of a fleet."""


def view_for(stream: TextIO, title: str = "", *, plain: bool) -> View:
    """Return live trees on a terminal, plain lines in a pipe; `Speech` is for ``--json``.

    Args:
        title: The title of a fleet; a mission alone has its own.
    """
    console = EscapingConsole(stream)
    if plain or not console.is_terminal or console.is_dumb_terminal:
        return PlainView(stream, title)
    capture = OutputCapture()
    return LiveView(EscapingConsole(capture.terminal), capture, title)


class PlainView(View):
    """A line for each leaf that starts or ends, and for what others do to the mission.

    Of several robots, each line has the name.
    """

    def __init__(self, stream: TextIO, title: str = "") -> None:
        self._stream = stream
        self._title = title
        self._lines: dict[MissionRun, PlainLines] = {}

    def open(self, session: Session) -> None:
        """Print what is run."""
        width = max(len(run.name) for run in session.runs)
        print(self._title or _title(session), file=self._stream, flush=True)
        for run in session.runs:
            who = f"{run.name:{width}}  " if run.name else ""
            self._lines[run] = PlainLines(
                self._stream,
                run.executive,
                lambda: session.start_ns,
                lambda: session.now_ns,
                who=who,
            )
            if run.name:
                mission = run.mission
                line = f"  {who}{mission.name} ({mission.robot}, seed {mission.seed})"
                print(escape_control(line), file=self._stream, flush=True)

    def on_event(self, run: MissionRun, event: Event) -> None:
        """Print a change, or a line of the mission."""
        if isinstance(event, NodeChanged):
            self._lines[run].on_change(event)
        elif (text := speech_of(event)) is not None:
            self._lines[run].say(text)

    def refresh(self) -> None:
        """Print what others have done to the missions."""
        for lines in self._lines.values():
            lines.refresh()


class ServedLines(PlainView):
    """The lines of a mission that a server runs; the server prints the mission's lines."""

    def open(self, session: Session) -> None:
        """Print what is run."""
        mission = session.mission
        self._title = escape_control(f"{mission.name} (seed {mission.seed})")
        super().open(session)

    def on_event(self, run: MissionRun, event: Event) -> None:
        """Print a change."""
        if isinstance(event, NodeChanged):
            super().on_event(run, event)


class LiveView(View):
    """The trees of all missions, drawn repeatedly, at most ten times a second.

    Lines of missions, requests, and the output of others scroll above. Several trees are below each
    other, each with as many rows as fit.

    Args:
        console: A terminal.
        capture: Keeps the output of others to that terminal; None keeps nothing.
        title: The title of a fleet.
    """

    def __init__(
        self, console: Console, capture: OutputCapture | None = None, title: str = ""
    ) -> None:
        self.console = console
        self.marks = marks_for(console.encoding)
        self._capture = capture
        self._title = title
        self._session: Session | None = None
        self._watch = Stopwatch()
        self._next_frame_s = 0.0
        self._above: list[Text] = []
        self._controls: dict[MissionRun, ControlLines] = {}
        self._trees: list[LiveTree] = []
        self._width = 0
        self._clock_lines = ExitStack()
        self._live = Live(
            console=console,
            auto_refresh=False,
            vertical_overflow="crop",
            redirect_stdout=False,
            redirect_stderr=False,
        )

    def open(self, session: Session) -> None:
        """Begin to draw."""
        self._session, self._watch = session, Stopwatch()
        self._width = max(len(run.name) for run in session.runs)
        for run in session.runs:
            header = partial(self._robot_header, run) if self._title else self._header
            self._trees.append(LiveTree(self.console, run.executive, header))
            self._controls[run] = ControlLines(run.executive)
        if self._capture:
            self._capture.start()
        self._live.start()
        self._clock_lines.enter_context(told_by(self._tell))

    def close(self) -> None:
        """Draw for the last time, and give the terminal back."""
        self._clock_lines.close()
        with suppress(OSError):  # of a terminal that was closed; the run still saves its files
            if self._session is not None:
                self._draw()
                self._live.stop()
            if self._capture:
                for line in self._capture.stop():
                    self.console.print(Text.from_ansi(line))

    def on_event(self, run: MissionRun, event: Event) -> None:
        """Show an event as a line that scrolls by; the tree is drawn in any case."""
        if (text := speech_of(event)) is not None:
            self._scroll(run, text)

    def refresh(self) -> None:
        """Draw, if the last frame is old enough."""
        for run, controls in self._controls.items():
            for line in controls.take():
                self._scroll(run, line)
        if self._watch.elapsed_s >= self._next_frame_s:
            self._next_frame_s = self._watch.elapsed_s + FRAME_S
            self._draw()

    def _tell(self, line: str) -> None:
        """Show a line about a callback that holds this thread, at once, from another thread."""
        self._above.append(Text(clean(line, self.marks), style="bold red"))
        self._draw()

    def _scroll(self, run: MissionRun, text: str) -> None:
        """Have lines scroll by above the picture, with the time since the start."""
        self._collect()
        who = f"{run.name:{self._width}}" if run.name else ""
        for line in lines_of(text):
            words = f"{who}  {clean(line, self.marks)}"
            self._above.append(Text(timed(self._elapsed_ns, words)))

    def _draw(self) -> None:
        self._collect()
        if self._capture and all(size := self._capture.size()):
            self.console.size = ConsoleDimensions(*size)
        with self.console:  # in one write, so that it does not flicker
            for text in self._above:
                self.console.print(text)
            self._live.update(self._picture(), refresh=True)
        self._above.clear()

    def _collect(self) -> None:
        """Take what others have written."""
        if self._capture:
            self._above += [coloured(line) for line in self._capture.take()]

    def _picture(self) -> Group:
        if not self._title:
            return self._trees[0].render()
        rows = max(self.console.height - ABOVE, 1) // len(self._trees)
        trees = [tree.render(max(rows - 1, 0)) for tree in self._trees]
        time, factor = seconds(self._elapsed_ns / NS), f"{self._factor:.0f} x real time"
        above = clean(f"{self._title}   {time}   {factor}", self.marks)
        return Group(Text(above, style="bold", no_wrap=True, overflow="ellipsis"), *trees)

    @property
    def _elapsed_ns(self) -> int:
        assert self._session is not None, "it is open"
        return self._session.now_ns - self._session.start_ns

    @property
    def _factor(self) -> float:
        wall_s = self._watch.elapsed_s
        return self._elapsed_ns / NS / wall_s if wall_s > 0 else 0.0

    def _header(self) -> str:
        """The line above the tree of a mission alone."""
        session = self._session
        assert session is not None, "it is open"
        executive, time = session.executive, seconds(self._elapsed_ns / NS)
        before = f"{_title(session)}   {time}   {self._factor:.0f} x real time   "
        if cell_len(f"{before}{executive.mission_state.conclusion[0]}") > self.console.width:
            before = f"{session.mission.name}   {time}   "  # the state must not be cut off
        return before + executive.mission_state.headline

    def _robot_header(self, run: MissionRun) -> str:
        """Return the line above the tree of one of several robots: its state, and what runs."""
        executive, mission = run.executive, run.mission
        parts = [f"{run.name:{self._width}}", mission.name, executive.mission_state.headline]
        running = ", ".join(leaf.name for leaf in executive.running_leaves)
        if running and cell_len("  ".join([*parts, running])) <= self.console.width:
            parts.append(running)
        return "  ".join(parts)


def _title(session: Session) -> str:
    mission = session.mission
    where = f" in {session.world}" if mission.world and session.world else ""
    return escape_control(f"{mission.name}{where} ({mission.robot}, seed {mission.seed})")


class LiveTree:
    """The picture of a running mission.

    Args:
        console: A terminal.
        executive: Whose tree to draw.
        header: Gives the line above the tree.
    """

    def __init__(self, console: Console, executive: Executive, header: Callable[[], str]) -> None:
        self._console = console
        self._executive = executive
        self._header = header
        self._marks = marks_for(console.encoding)
        self._state = executive.mission_state

    def render(self, room: int | None = None) -> Group:
        """Return the whole view: header and tree, with at most `room` rows."""
        if room is None:
            room = max(self._console.height - 3, 1)
        failed = set(self._state.failure_path())
        depths = [info.depth for info in self._executive.node_infos]
        rows: list[Text] = []
        focus: list[int] = []
        above: list[int] = []
        for index, (depth, shown) in enumerate(zip(depths, self._state.shown_nodes(), strict=True)):
            rows.append(self._row(index, depth, shown))
            above[depth:] = [index]
            if index in failed or (shown.status is Status.RUNNING and not failed):
                focus = above.copy()
        return Group(
            Text(
                clean(self._header(), self._marks), style="bold", no_wrap=True, overflow="ellipsis"
            ),
            *(rows[number] for number in _shown(len(rows), focus, room)),
        )

    def _doing_of(self, index: int) -> tuple[str, LeafProgress | None]:
        node = self._executive.nodes[index]
        return node.feedback_message, progress_of(node)

    def _row(self, index: int, depth: int, shown: NodeEnd) -> Text:
        node, status, message = self._executive.nodes[index], shown.status, shown.message
        progress = None
        if status is Status.RUNNING:
            message, progress = self._doing_of(index)
        row = Text(no_wrap=True, overflow="ellipsis")
        sign = f"{'  ' * depth}{self._marks.status[status]} "
        row.append(sign + clean(node.name, self._marks), style=STYLES[status])
        if progress is not None:
            label, value, limit = progress.label, progress.value, progress.limit
            drawn = bar(value, limit, BAR_WIDTH, self._marks)
            row.append(f"  {drawn} {progress_figures(label, value, limit)}", style="cyan")
        has_run = status is not Status.INVALID or shown.time_ns is not None
        if message and has_run:
            row.append(f"  {clean(message, self._marks)}", style="dim")
        return row


def _shown(count: int, focus: Sequence[int], room: int) -> list[int]:
    """Return as many rows as fit, with the end of the path to one in view."""
    if count <= room:
        return list(range(count))
    if room <= 0:
        return []
    shown = set(focus[-room:])
    at = focus[-1] if focus else 0
    near = sorted(range(count), key=lambda row: abs(row - at))
    others = (row for row in near if row not in shown)
    return sorted(shown | set(islice(others, room - len(shown))))
