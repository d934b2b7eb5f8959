"""A run as a live tree: status, what each running leaf does, progress towards its limit."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Self

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.text import Text

from bt_mission.behaviours.action_leaf import ActionLeaf
from bt_mission.behaviours.progress import LeafProgress, progress_of
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.events.status_marks import STYLES, glyphs_for
from bt_mission.executive.executive import Executive

FRAME_S = 0.1
BAR_WIDTH = 12
LOG_LINES = 4


class LiveTree:
    """Draws the tree of a running mission, at most ten times a second.

    :param console: a terminal.
    :param executive: whose tree to draw.
    :param header: gives the line above the tree.
    """

    def __init__(self, console: Console, executive: Executive, header: Callable[[], str]) -> None:
        self._console = console
        self._executive = executive
        self._header = header
        self._glyphs = glyphs_for(console.encoding)
        self._bars = ("█", "░") if self._glyphs[Status.SUCCESS] == "✓" else ("#", ".")
        self._said: deque[str] = deque(maxlen=LOG_LINES)
        self._watch = Stopwatch()
        self._next_frame_s = 0.0
        self._live = Live(
            console=console, auto_refresh=False, transient=False, vertical_overflow="crop"
        )

    def __enter__(self) -> Self:
        self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._live.update(self.render(), refresh=True)
        self._live.stop()

    def say(self, text: str) -> None:
        """Show what a mission says below the tree."""
        self._said.append(text)

    def refresh(self) -> None:
        """Draw, if the last frame is old enough."""
        if self._watch.elapsed_s >= self._next_frame_s:
            self._next_frame_s = self._watch.elapsed_s + FRAME_S
            self._live.update(self.render(), refresh=True)

    def render(self) -> RenderableType:
        """The whole picture: header, tree, what was said."""
        rows = list(self._rows(self._executive.root, ""))
        room = max(self._console.height - 3 - len(self._said), 1)
        said = [Text(f"  {line}", style="italic", no_wrap=True) for line in self._said]
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
        row.append(f"{indent}{self._glyphs[node.status]} {node.name}", style=STYLES[node.status])
        progress = progress_of(node)
        if progress is not None:
            row.append(f"  {self._bar(progress)}", style="cyan")
        if node.feedback_message and (node.status is not Status.INVALID or _was_halted(node)):
            row.append(f"  {node.feedback_message}", style="dim")
        return row

    def _bar(self, progress: LeafProgress) -> str:
        share = progress.value / progress.limit if progress.limit > 0 else 1.0
        full = round(BAR_WIDTH * min(max(share, 0.0), 1.0))
        drawn = self._bars[0] * full + self._bars[1] * (BAR_WIDTH - full)
        return f"{drawn} {progress.value:.4g} of {progress.limit:.4g}"


def _was_halted(node: Behaviour) -> bool:
    return isinstance(node, ActionLeaf) and node.was_halted


def _window(rows: list[tuple[Status, Text]], room: int) -> list[Text]:
    """As many rows as fit, with the deepest running one in sight."""
    if len(rows) <= room:
        return [text for _, text in rows]
    running = [i for i, (status, _) in enumerate(rows) if status is Status.RUNNING]
    focus = running[-1] if running else 0
    first = min(max(focus - room // 2, 0), len(rows) - room)
    return [text for _, text in rows[first : first + room]]
