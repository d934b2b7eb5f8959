"""The signs of a watcher's view, with and without UTF-8, and pieces of text made of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from py_trees.common import Status
from rich.cells import cell_len, set_cell_size

from bt_mission.base.stamps import NS
from bt_mission.base.text import escape_control, seconds
from bt_mission.executive.events.log import ASCII, UNICODE, glyphs_for

PLACES = "123456789abcdefghijklmnopqrstuvwxyz"
"""Signs of waypoints on the map, in order."""


@dataclass(frozen=True)
class Marks:
    """The signs of an output; those of UTF-8 unless others are given.

    Args:
        wall: The upper half of a cell, the lower, and the whole.
        arrows: The arrows of the robot, from east on and counter-clockwise; four or eight.
    """

    status: Mapping[Status, str]
    full: str = "█"
    empty: str = "░"
    cursor: str = "»"
    breakpoint: str = "●"
    then: str = " ▸ "
    rule: str = "─"
    wall: tuple[str, str, str] = ("▀", "▄", "█")
    unknown: str = "░"
    trail: str = "·"
    scan: str = "∙"
    arrows: str = "→↗↑↖←↙↓↘"
    cut: str = "…"
    is_ascii: bool = False


SIGNS = Marks(UNICODE)
ASCII_SIGNS = Marks(
    ASCII,
    full="#",
    empty=".",
    cursor=">",
    breakpoint="*",
    then=" > ",
    rule="-",
    wall=("#", "#", "#"),
    unknown=":",
    trail=".",
    scan="+",
    arrows=">^<v",
    cut="~",
    is_ascii=True,
)


def marks_for(encoding: str | None) -> Marks:
    """The signs that a stream of this encoding can show."""
    return SIGNS if glyphs_for(encoding) is UNICODE else ASCII_SIGNS


def clean(text: str, marks: Marks) -> str:
    """Return a foreign text on one line, escaped, in signs of the output."""
    shown = escape_control(text)
    return shown.encode("ascii", "replace").decode() if marks.is_ascii else shown


Span = tuple[str, str]
"""A piece of text and the name of its style: see :data:`bt_mission.views.tui.pane.STYLES`."""


def stopwatch(time_ns: int) -> str:
    """Return a duration in at most seven characters: ``8.45 s``, ``2:05``, ``1:02:05``."""
    if round(time_ns / NS, 2) < 60:
        return seconds(time_ns / NS)
    minutes, rest = divmod(int(time_ns / NS + 0.005), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def bar(value: float, limit: float, width: int, marks: Marks) -> str:
    """Return a bar of the progress to a limit."""
    full = round(width * min(max(value / limit, 0.0), 1.0)) if limit > 0 else width
    return marks.full * full + marks.empty * (width - full)


def fit(spans: Iterable[Span], width: int | None, marks: Marks) -> list[Span]:
    """Return the spans with their texts escaped, cut to a width of the terminal; None does not cut.

    A cut text ends with a sign.
    """
    shown = [(clean(text, marks), style) for text, style in spans]
    return shown if width is None else _cut(shown, width, marks)


def _cut(spans: Iterable[Span], width: int, marks: Marks) -> list[Span]:
    fitted: list[Span] = []
    left = width
    for text, style in spans:
        length = cell_len(text)
        if length > left:
            if left > 0:
                fitted.append((set_cell_size(text, left - 1) + marks.cut, style))
            elif fitted:
                last, last_style = fitted[-1]
                fitted[-1] = (set_cell_size(last, cell_len(last) - 1) + marks.cut, last_style)
            return fitted
        if text:
            fitted.append((text, style))
            left -= length
    return fitted


def text_of(spans: Iterable[Span]) -> str:
    """The spans without their styles."""
    return "".join(text for text, _ in spans)
