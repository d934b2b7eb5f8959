"""Styles of the full-screen view. Each says by weight or order, too, what it says by colour."""

from __future__ import annotations

from collections.abc import Mapping

from py_trees.common import Status
from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip

from bt_mission.events.status_marks import STYLES as STATUS_LOOKS
from bt_mission.views.terminal.marks import Marks
from bt_mission.views.terminal.words import Span, fit

STYLES: Mapping[str, Style] = {
    "": Style(),
    "running": Style.parse(STATUS_LOOKS[Status.RUNNING]),
    "success": Style.parse(STATUS_LOOKS[Status.SUCCESS]),
    "failure": Style.parse(STATUS_LOOKS[Status.FAILURE]),
    "idle": Style.parse(STATUS_LOOKS[Status.INVALID]),
    "title": Style(bold=True),
    "words": Style(dim=True),
    "time": Style(),
    "bar": Style(color="cyan"),
    "chosen": Style(bold=True, reverse=True),
    "folded": Style(color="magenta"),
    "breakpoint": Style(color="red", bold=True),
    "paused": Style(color="yellow", bold=True, reverse=True),
    "rule": Style(dim=True),
    "rule title": Style(bold=True),
    "key": Style(bold=True),
    "notice": Style(color="yellow", bold=True),
    "wall": Style(),
    "trail": Style(color="green"),
    "scan": Style(color="yellow", bold=True),
    "waypoint": Style(color="magenta", bold=True),
    "robot": Style(color="cyan", bold=True, reverse=True),
}


def strip(spans: list[Span], width: int, marks: Marks) -> Strip:
    """Spans as a line of a widget, cut and filled to its width."""
    segments = [Segment(text, STYLES[style]) for text, style in fit(spans, width, marks)]
    return Strip(segments).extend_cell_length(width)


def rule(title: str, right: str, width: int, marks: Marks) -> list[Span]:
    """The line above a panel: its title, and what stands at its right end if there is room."""
    spans: list[Span] = [(f"{marks.rule} ", "rule"), (title, "rule title"), (" ", "rule")]
    room = width - 3 - len(title)
    if right and room > len(right) + 4:
        return [
            *spans,
            (marks.rule * (room - len(right) - 3), "rule"),
            (f" {right} ", "words"),
            (marks.rule, "rule"),
        ]
    return [*spans, (marks.rule * max(room, 0), "rule")]
