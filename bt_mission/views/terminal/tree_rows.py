"""How a node of a watched tree stands in its row."""

from __future__ import annotations

import math

from py_trees.common import Status

from bt_mission.events.mission_state import MissionState
from bt_mission.views.terminal.marks import Marks, clean
from bt_mission.views.terminal.outline import Outline
from bt_mission.views.terminal.words import Span, bar, seconds

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
    """Status, name, time in state, progress and words of a node; not yet cut to the width.

    The indent stops growing at a third of the width, so that deep nodes can still be read.
    """
    assert mission.tree is not None
    node, status = mission.tree.nodes[index], mission.statuses[index]
    style = STATUS_STYLES[status]
    indent = " " * min((1 if width < TINY else 2) * outline.depth[index], width // 3)
    row: list[Span] = [
        (_margin(mission, index, marks), "breakpoint"),
        (f"{indent}{marks.status[status]} ", style),
        (clean(node.name, marks), "chosen" if is_chosen else style),
    ]
    if hidden := outline.hidden(index):
        row.append((f" [+{hidden}]", "folded"))
    progress = _progress(mission, index, width, marks)
    if (time := time_in_state(mission, index)) and not (progress and width < TINY):
        row.append((f"  {time}", "time"))
    row += progress
    message = mission.messages[index]
    if message and (status is not Status.INVALID or mission.since_ns[index] is not None):
        row.append((f"  {clean(message, marks)}", "words"))
    return row


def time_in_state(mission: MissionState, index: int) -> str:
    """How long a node has been running, or had run when it ended; empty where nobody saw it."""
    if mission.statuses[index] is Status.RUNNING:
        since_ns = mission.since_ns[index]
        return "" if since_ns is None else seconds(max(mission.now_ns - since_ns, 0))
    ran_ns = mission.ran_ns[index]
    return seconds(ran_ns) if ran_ns and mission.statuses[index] is not Status.INVALID else ""


def _margin(mission: MissionState, index: int, marks: Marks) -> str:
    assert mission.tree is not None
    node = mission.tree.nodes[index]
    is_set = node.path in mission.breakpoints or node.name in mission.breakpoints
    return marks.breakpoint if is_set else " "


def _progress(mission: MissionState, index: int, width: int, marks: Marks) -> list[Span]:
    progress = mission.progress.get(index) if index in mission.running else None
    if progress is None or progress.limit <= 0 or not math.isfinite(progress.value):
        return []
    if width < TINY:
        return [(f" {min(max(progress.value / progress.limit, 0), 1):.0%}", "bar")]
    unit = " s" if progress.label == "s" else ""
    # A fixed number of digits: figures that change all the time should not jump.
    digits = 1 if unit else 0 if progress.value.is_integer() and progress.limit >= 3 else 2
    value = f"{progress.value:.{digits}f}"
    figures = f"{value} of {progress.limit:.4g}{unit}"
    if width < NARROW:
        return [(f"  {figures}", "bar")]
    drawn = bar(progress.value, progress.limit, BAR_WIDTH, marks)
    return [(f"  {drawn}", "bar"), (f" {figures}", "bar")]
