"""The row of a node of a watched tree."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from py_trees.common import Status

from bt_mission.executive.events.events import NodeInfo
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.views.terminal.marks import Marks, Span, bar, stopwatch


class Outline:
    """The rows of a tree, each an index of a node.

    Args:
        nodes: Depth first, the root first.
    """

    def __init__(self, nodes: Sequence[NodeInfo]) -> None:
        count = len(nodes)
        self._nodes = nodes
        self.depth = [0] * count
        self._end = list(range(1, count + 1))
        for index in range(1, count):
            self.depth[index] = self.depth[nodes[index].parent] + 1
        for index in range(count - 1, 0, -1):
            parent = nodes[index].parent
            self._end[parent] = max(self._end[parent], self._end[index])
        self.folded: set[int] = set()
        self.rows: list[int] = []
        self._row_of: dict[int, int] = {}
        self._arrange()

    def hidden(self, index: int) -> int:
        """Return how many nodes below a node are folded away; 0 if it is not folded."""
        return self._end[index] - index - 1 if index in self.folded else 0

    def has_children(self, index: int) -> bool:
        """Return whether there are nodes below a node."""
        return self._end[index] > index + 1

    def row_of(self, index: int) -> int:
        """The row of a node, or of the folded node that it lies below."""
        while index not in self._row_of:
            index = self._nodes[index].parent
        return self._row_of[index]

    def path_to(self, index: int) -> list[int]:
        """Return the nodes from the root to this one."""
        path = [index]
        while index:
            index = self._nodes[index].parent
            path.append(index)
        return path[::-1]

    def fold(self, index: int) -> None:
        """Hide what lies below a node."""
        if self.has_children(index):
            self.folded.add(index)
            self._arrange()

    def unfold(self, index: int) -> None:
        """Show what lies below a node."""
        self.folded.discard(index)
        self._arrange()

    def fold_all(self) -> None:
        """Hide all but the root and what is right below it."""
        self.folded = {index for index in range(1, len(self._nodes)) if self.has_children(index)}
        self._arrange()

    def unfold_all(self) -> None:
        """Show every node."""
        self.folded.clear()
        self._arrange()

    def reveal(self, index: int) -> int:
        """Unfold what hides a node. Return its row."""
        above = set(self.path_to(index)[:-1])
        if above & self.folded:
            self.folded -= above
            self._arrange()
        return self._row_of[index]

    def find(self, matches: Callable[[int], bool], start: int, *, step: int = 1) -> int | None:
        """Return the next node that matches, from the one after ``start`` on and round, or None.

        Args:
            step: 1 looks downwards, -1 upwards.
        """
        count = len(self._nodes)
        for offset in range(1, count + 1):
            index = (start + step * offset) % count
            if matches(index):
                return index
        return None

    def _arrange(self) -> None:
        rows = []
        index = 0
        while index < len(self._nodes):
            rows.append(index)
            index = self._end[index] if index in self.folded else index + 1
        self.rows = rows
        self._row_of = {index: row for row, index in enumerate(rows)}


def scrolled_to(row: int, above: Sequence[int], top: int, height: int, count: int) -> int:
    """Return the first row in view so that a row is, and as many of those above as fit.

    Nothing moves without need: while the row and all that fits above it are in view, the top stays.

    Args:
        above: Rows that belong to it, the farthest first, such as those of its ancestors.
        top: The present first row in view.
        height: Rows in view; count: rows of the whole list.
    """
    if height <= 0:
        return 0
    fitting = [ancestor for ancestor in above if row - ancestor < height]
    highest = fitting[0] if fitting else row
    top = min(top, highest)
    top = max(top, row - height + 1)
    return max(min(top, count - height), 0)


BAR_WIDTH = 12
NARROW, TINY = 50, 30
"""Columns below which a row has figures instead of a bar; and percent, with a smaller indent."""

STATUS_STYLES = {
    Status.SUCCESS: "success",
    Status.FAILURE: "failure",
    Status.RUNNING: "running",
    Status.INVALID: "idle",
}


def tree_row(
    mission: MissionState,
    outline: Outline,
    index: int,
    width: int,
    marks: Marks,
    *,
    is_chosen: bool = False,
) -> list[Span]:
    """Return status, name, time in state, progress and message of a node; not yet cut to the width.

    The indent stops growing at a third of the width, so that deep nodes can still be read.
    """
    assert mission.tree is not None
    node, shown = mission.tree.nodes[index], mission.current(index)
    status = shown.status
    style = STATUS_STYLES[status]
    indent = " " * min((1 if width < TINY else 2) * outline.depth[index], width // 3)
    row: list[Span] = [
        (_margin(mission, index, marks), "breakpoint"),
        (f"{indent}{marks.status[status]} ", style),
        (node.name, "chosen" if is_chosen else style),
    ]
    if hidden := outline.hidden(index):
        row.append((f" [+{hidden}]", "folded"))
    progress = _progress(mission, index, width, marks)
    if (time := time_in_state(mission, index)) and not (progress and width < TINY):
        row.append((f"  {time}", "time"))
    row += progress
    if shown.message and (status is not Status.INVALID or shown.time_ns is not None):
        row.append((f"  {shown.message}", "words"))
    return row


def time_in_state(mission: MissionState, index: int) -> str:
    """Return how long a node has been running, or had run when it ended; empty if unknown."""
    shown = mission.current(index)
    if shown.status is Status.RUNNING:
        return "" if shown.time_ns is None else stopwatch(max(mission.now_ns - shown.time_ns, 0))
    ran_ns = shown.ran_ns
    return stopwatch(ran_ns) if ran_ns and shown.status is not Status.INVALID else ""


def _margin(mission: MissionState, index: int, marks: Marks) -> str:
    assert mission.tree is not None
    node = mission.tree.nodes[index]
    is_set = node.path in mission.breakpoints or node.name in mission.breakpoints
    return marks.breakpoint if is_set else " "


def progress_figures(label: str, value: float, limit: float) -> str:
    """Return the progress as text: `0.32 of 0.6`, `1.8 of 20 s`.

    The number of digits is fixed, so that figures do not jump.
    """
    unit = " s" if label == "s" else ""
    digits = 1 if unit else 0 if value.is_integer() and limit >= 3 else 2
    return f"{value:.{digits}f} of {limit:.4g}{unit}"


def _progress(mission: MissionState, index: int, width: int, marks: Marks) -> list[Span]:
    progress = mission.progress.get(index) if index in mission.running else None
    if progress is None or progress.limit <= 0 or not math.isfinite(progress.value):
        return []
    if width < TINY:
        return [(f" {min(max(progress.value / progress.limit, 0), 1):.0%}", "bar")]
    figures = progress_figures(progress.label, progress.value, progress.limit)
    if width < NARROW:
        return [(f"  {figures}", "bar")]
    drawn = bar(progress.value, progress.limit, BAR_WIDTH, marks)
    return [(f"  {drawn}", "bar"), (f" {figures}", "bar")]
