"""The views of a run, and which one fits an output: a live tree, plain lines, or nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import islice
from typing import Self, TextIO

from py_trees.common import Status
from rich.cells import cell_len
from rich.console import Console, ConsoleDimensions, Group, RenderableType
from rich.live import Live
from rich.text import Text

from bt_mission.behaviours.leaves import LeafProgress, progress_of
from bt_mission.core.terminal.console import EscapingConsole, coloured
from bt_mission.core.text import escape_control, seconds
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.events.events import NodeChanged
from bt_mission.events.log import STYLES, verdict
from bt_mission.events.mission_state import NodeEnd
from bt_mission.executive.executive import Executive
from bt_mission.executive.status import MissionStatus
from bt_mission.sessions.session import Session, View
from bt_mission.views.terminal.lines import ControlLines, PlainLines, timed
from bt_mission.views.terminal.marks import bar, clean, marks_for
from bt_mission.views.terminal.output_capture import OutputCapture
from bt_mission.views.terminal.quiet import Quiet
from bt_mission.views.terminal.tree_rows import progress_figures

FRAME_S = 0.1
BAR_WIDTH = 12


def view_for(stream: TextIO, *, plain: bool) -> View:
    """A live tree on a terminal, plain lines in a pipe; `Quiet` is for ``--json``."""
    console = EscapingConsole(stream)
    if plain or not console.is_terminal or console.is_dumb_terminal:
        return PlainView(stream)
    capture = OutputCapture()
    return LiveView(EscapingConsole(capture.terminal), capture)


class PlainView(Quiet):
    """A line for each leaf that starts or ends, and for what others do to the mission."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._lines: PlainLines | None = None

    def open(self, session: Session, _wall: Stopwatch, /) -> None:
        """Say what is run."""
        self._lines = PlainLines(
            self._stream, session.executive, lambda: session.start_ns, lambda: session.now_ns
        )
        print(_title(session), file=self._stream, flush=True)

    def on_change(self, change: NodeChanged) -> None:
        """Show a change."""
        if self._lines:
            self._lines.on_change(change)

    def refresh(self) -> None:
        """Show what others have done to the mission."""
        if self._lines:
            self._lines.refresh()

    def say(self, text: str) -> None:
        """Show what the mission says."""
        if self._lines:
            self._lines.say(text)


class LiveScreen:
    """A picture that is drawn again and again, at most ten times a second.

    What missions say, what others do to them, and what anybody else writes to the terminal scrolls
    by above it.

    Args:
        console: A terminal.
        capture: Keeps what others write to that terminal; None where nothing is kept.
    """

    def __init__(self, console: Console, capture: OutputCapture | None = None) -> None:
        self.console = console
        self.marks = marks_for(console.encoding)
        self._capture = capture
        self._render: Callable[[], RenderableType] | None = None
        self._watch = Stopwatch()
        self._next_frame_s = 0.0
        self._above: list[Text] = []
        self._live = Live(
            console=console,
            auto_refresh=False,
            vertical_overflow="crop",
            redirect_stdout=False,
            redirect_stderr=False,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._render:
            self._draw(self._render)
            self._live.stop()
        if self._capture:
            for line in self._capture.stop():
                self.console.print(Text.from_ansi(line))

    def begin(self, render: Callable[[], RenderableType]) -> None:
        """Begin to draw what this gives."""
        self._render = render
        if self._capture:
            self._capture.start()
        self._live.start()

    def refresh(self) -> None:
        """Draw, if the last frame is old enough."""
        if self._render and self._watch.elapsed_s >= self._next_frame_s:
            self._next_frame_s = self._watch.elapsed_s + FRAME_S
            self._draw(self._render)

    def scroll(self, time_ns: int, text: str, who: str = "") -> None:
        """Have lines scroll by above the picture, with the time since the start, ns."""
        self._collect()
        for line in text.splitlines():
            self._above.append(Text(timed(time_ns, f"{who}  {clean(line, self.marks)}")))

    def _draw(self, render: Callable[[], RenderableType]) -> None:
        self._collect()
        if self._capture and all(size := self._capture.size()):
            self.console.size = ConsoleDimensions(*size)
        with self.console:  # in one write, so that it does not flicker
            for text in self._above:
                self.console.print(text)
            self._live.update(render(), refresh=True)
        self._above.clear()

    def _collect(self) -> None:
        """Take what others have written."""
        if self._capture:
            self._above += [coloured(line) for line in self._capture.take()]


class LiveView(LiveScreen, Quiet):
    """The tree of a mission, drawn again and again."""

    def __init__(self, console: Console, capture: OutputCapture | None = None) -> None:
        super().__init__(console, capture)
        self._session: Session | None = None
        self._controls: ControlLines | None = None

    def open(self, session: Session, wall: Stopwatch, /) -> None:
        """Begin to draw."""

        def header() -> str:
            virtual_s = (session.now_ns - session.start_ns) / 1e9
            factor = virtual_s / wall.elapsed_s if wall.elapsed_s > 0 else 0.0
            executive = session.executive
            state = verdict(executive.state, executive.explanation)
            time = seconds(virtual_s)
            before = f"{_title(session)}   {time}   {factor:.0f} x real time   "
            if cell_len(f"{before}{executive.state}") > self.console.width:
                before = f"{session.mission.name}   {time}   "  # how it goes must not be cut off
            return before + state

        self._session = session
        self._controls = ControlLines(session.executive)
        tree = LiveTree(self.console, session.executive, header)
        self.begin(tree.render)

    def refresh(self) -> None:
        """Draw, if the last frame is old enough."""
        if self._controls:
            for line in self._controls.take():
                self.say(line)
        super().refresh()

    def say(self, text: str) -> None:
        """Show what the mission says."""
        if self._session is not None:
            self.scroll(self._session.now_ns - self._session.start_ns, text)


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
        self._depths = [info.depth for info in executive.node_infos]
        self._doing: dict[int, tuple[str, LeafProgress | None]] = {}
        """What running nodes said when the mission was last ticked."""
        executive.after_tick.append(self._note_running)

    def render(self, room: int | None = None) -> Group:
        """The whole picture: header and tree, of which so many rows are shown at most."""
        if room is None:
            room = max(self._console.height - 3, 1)
        failed = set(self._state.failure_path())
        rows: list[Text] = []
        focus: list[int] = []
        above: list[int] = []
        for index, (depth, shown) in enumerate(
            zip(self._depths, self._state.shown_nodes(), strict=True)
        ):
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

    @property
    def _is_running(self) -> bool:
        return self._executive.status is MissionStatus.RUNNING

    def _note_running(self) -> None:
        """Keep what runs; a halt at the end takes it from the nodes."""
        if self._is_running:
            self._doing = {index: self._doing_of(index) for index in self._state.running}

    def _doing_of(self, index: int) -> tuple[str, LeafProgress | None]:
        node = self._executive.nodes[index]
        return node.feedback_message, progress_of(node)

    def _row(self, index: int, depth: int, shown: NodeEnd) -> Text:
        node, status, message = self._executive.nodes[index], shown.status, shown.message
        progress = None
        if status is Status.RUNNING:
            message, progress = self._doing_of(index)
        elif status is Status.INVALID and index in self._doing and not self._is_running:
            status, (message, progress) = Status.RUNNING, self._doing[index]
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
    """As many rows as fit, with the end of the path to one in sight, and the rows around that."""
    if count <= room:
        return list(range(count))
    if room <= 0:
        return []
    shown = set(focus[-room:])
    at = focus[-1] if focus else 0
    near = sorted(range(count), key=lambda row: abs(row - at))
    others = (row for row in near if row not in shown)
    return sorted(shown | set(islice(others, room - len(shown))))
