"""Times, shares and styled pieces of text, as the views of a mission show them."""

from __future__ import annotations

from collections.abc import Iterable

from rich.cells import cell_len, set_cell_size

from bt_mission.core.stamps import NS
from bt_mission.views.terminal.marks import Marks

Span = tuple[str, str]
"""A piece of text and the name of its style: see :data:`bt_mission.views.tui.pane.STYLES`."""


def seconds(time_ns: int) -> str:
    """A duration in at most seven characters: ``8.4 s``, ``2:05``, ``1:02:05``."""
    tenths = round(time_ns / NS * 10)
    if tenths < 600:
        return f"{tenths / 10:.1f} s"
    minutes, rest = divmod(tenths // 10, 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def bar(value: float, limit: float, width: int, marks: Marks) -> str:
    """How far something has come towards a limit."""
    full = round(width * min(max(value / limit, 0.0), 1.0)) if limit > 0 else width
    return marks.full * full + marks.empty * (width - full)


def fit(spans: Iterable[Span], width: int, marks: Marks) -> list[Span]:
    """The spans, cut to a width of the terminal; what is cut ends with a sign for that."""
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
