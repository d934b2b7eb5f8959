"""The timeline: for each node a row, for each time that it ran a bar.

Time runs along x in the drawing's own seconds, so whoever zooms only moves the drawing's window;
rows have a fixed height.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bt_mission.core.text import escape_markup, seconds
from bt_mission.recording.model import Floats, RecordedRun, Span, Times
from bt_mission.views.html_report.figures import clearance, duration_s, inner_nodes, since_start_s
from bt_mission.views.html_report.markup import element, hint, legend, number, rows, void

ROW = 22
"""Pixels."""
HINT = (
    "Point at the timeline. Wheel or two fingers zoom, dragging moves, a double click shows all; "
    "with the keyboard: arrows, + and -, 0."
)
LEGEND = (
    ("success", "success"),
    ("failure", "failure"),
    ("halted", "halted"),
    ("running", "still running"),
)
MOST_ROWS = 600
MOST_SPANS = 1500
"""Of one node; beyond it, neighbours of the same kind are drawn as one."""


@dataclass(frozen=True)
class TimelineRow:
    """A node that has run, and what is drawn of it: bars with the number of runs in each."""

    node: int
    bars: list[tuple[Span, int]]


def rows_of(run: RecordedRun) -> list[TimelineRow]:
    """The nodes that have run, in the order of the tree."""
    least_ns = max(1, (run.end_ns - run.start_ns) // MOST_SPANS)
    found = []
    for node, spans in enumerate(run.spans):
        if spans:
            bars = [(span, 1) for span in spans]
            found.append(
                TimelineRow(node, bars if len(spans) <= MOST_SPANS else _merged(spans, least_ns))
            )
    return found[:MOST_ROWS]


def _merged(spans: tuple[Span, ...], least_ns: int) -> list[tuple[Span, int]]:
    merged: list[tuple[Span, int]] = []
    for span in spans:
        if merged:
            last, count = merged[-1]
            is_near = span.start_ns - last.end_ns < least_ns
            if last.status == span.status and is_near:
                joined = Span(last.start_ns, span.end_ns, span.status, span.message)
                merged[-1] = (joined, count + 1)
                continue
        merged.append((span, 1))
    return merged


def timeline(run: RecordedRun) -> str:
    """The whole section."""
    shown = rows_of(run)
    duration = duration_s(run)
    height = ROW * len(shown)
    silent = len(run.tree) - sum(1 for spans in run.spans if spans)
    inner = inner_nodes(run)
    bars = rows(
        rows(
            _bar(run, row, index, bar, "inner" if row.node in inner else "leaf") for bar in row.bars
        )
        for index, row in enumerate(shown)
    )
    drawing = zoomed(
        f"{_stripes(len(shown), duration)}{bars}",
        "bars",
        (duration, height),
        "When each node ran",
        style=f"height:{height}px",
    )
    names = rows(_name(run, row) for row in shown)
    note = f"{silent} {'node' if silent == 1 else 'nodes'} never ran." if silent else ""
    if len(shown) == MOST_ROWS:
        note = f"Only the first {MOST_ROWS} nodes that ran are shown."
    return rows(
        [
            '<div class="timeline" tabindex="0" aria-label="Timeline of all nodes">',
            element("div", names, class_="names"),
            element("div", drawing + axis(duration), class_="drawing"),
            "</div>",
            element("p", HINT, class_="reading script", aria_live="polite"),
            legend("dot", LEGEND),
            hint(note),
        ]
    )


def zoomed(
    content: str, name: str, size: tuple[float, int], label: str, style: str | None = None
) -> str:
    """Draw over time, with a cursor that the script moves; the size is in s and in px."""
    duration, height = size
    cursor = void("line", class_="cursor", x1=0, x2=0, y1=0, y2=height, visibility="hidden")
    return element(
        "svg",
        content + cursor,
        class_=f"{name} zoomed",
        viewBox=f"0 0 {number(duration)} {height}",
        preserveAspectRatio="none",
        style=style,
        role="img",
        aria_label=label,
    )


def axis(duration: float) -> str:
    """Times below a drawing; the script writes others when it is zoomed."""
    step = tick_step(duration)
    marks = []
    at = 0.0
    while at <= duration * 0.97:
        style = f"left:{number(100 * at / duration, 2)}%"
        marks.append(element("span", f"{number(at, 2)} s", style=style))
        at += step
    return element("div", rows(marks), class_="axis", aria_hidden="true")


def tick_step(duration: float) -> float:
    """Seconds between marks, so that there are about six."""
    for step in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 3600):
        if duration / step <= 7:
            return float(step)
    return duration / 6


def _bar(run: RecordedRun, row: TimelineRow, index: int, bar: tuple[Span, int], kind: str) -> str:
    span, count = bar
    name = run.tree[row.node].name
    start, length = since_start_s(run, span.start_ns), (span.end_ns - span.start_ns) / 1e9
    what = f"{name}: {span.status} after {seconds(length)} at {seconds(start + length)}"
    if count > 1:
        what = f"{name}: {count} times {span.status} until {seconds(start + length)}"
    title = element("title", escape_markup(f"{what}\n{span.message}".strip()))
    y, look = index * ROW + 4, f"bar {kind} {span.status}"
    if length == 0:
        # Of no width, so it is a line, which keeps its width however the drawing is zoomed.
        return element("line", title, class_=look, x1=start, x2=start, y1=y, y2=y + ROW - 8)
    return element("rect", title, class_=look, x=start, y=y, width=length, height=ROW - 8)


def _stripes(count: int, duration: float) -> str:
    return rows(
        void("rect", class_="stripe", x=0, y=index * ROW, width=duration, height=ROW)
        for index in range(0, count, 2)
    )


def _name(run: RecordedRun, row: TimelineRow) -> str:
    node = run.tree[row.node]
    last = row.bars[-1][0].status
    return element(
        "div",
        element("span", "", class_=f"dot {last}", title=last) + escape_markup(node.name),
        class_="name",
        style=f"padding-left:{min(node.depth, 8) * 10 + 4}px",
        title=f"{node.name} ({node.kind}, {node.path})",
    )


MOST_POINTS = 1200
HEIGHT = 100
TOP, BOTTOM = 14, 94
"""Where the greatest and the least value lie, so that the labels have room."""


@dataclass(frozen=True)
class LineChart:
    """One figure over time, with its unit."""

    name: str
    unit: str
    times: Times
    values: Floats
    least: float | None = None
    """Where the axis begins, unless something is below it."""


def charts_of(run: RecordedRun) -> list[LineChart]:
    """What is known of the run."""
    track, near = run.track, clearance(run)
    found = [
        LineChart("speed", "m/s", track.times, track.speed, 0.0),
        LineChart("distance", "m", track.times, track.distance, 0.0),
        LineChart("clearance", "m", near.times, near.values, 0.0),
        LineChart("battery", "%", run.battery.times, run.battery.values),
    ]
    return [chart for chart in found if len(chart.times)]


def charts(run: RecordedRun) -> str:
    """All of them."""
    known = charts_of(run)
    if not known:
        return hint("The recording has none of these topics.")
    return rows([*(_chart(run, chart) for chart in known), axis(duration_s(run))])


def thinned(chart: LineChart) -> tuple[Times, Floats]:
    """So many points that the eye misses nothing: of each stretch its least and its greatest."""
    count = len(chart.times)
    if count <= MOST_POINTS:
        return chart.times, chart.values
    keep: set[int] = {0, count - 1}
    for part in np.array_split(np.arange(count), MOST_POINTS // 2):
        keep.add(int(part[np.argmin(chart.values[part])]))
        keep.add(int(part[np.argmax(chart.values[part])]))
    chosen = np.array(sorted(keep))
    return chart.times[chosen], chart.values[chosen]


def bounds(chart: LineChart) -> tuple[float, float]:
    """Least and greatest value of its axis."""
    low, high = float(chart.values.min()), float(chart.values.max())
    if chart.least is not None:
        low = min(low, chart.least)
    if high - low < 1e-6:
        high = low + 1.0
    return low, high


def _chart(run: RecordedRun, chart: LineChart) -> str:
    low, high = bounds(chart)
    times, values = thinned(chart)
    points = " ".join(
        f"{number(t, 2)},{number(BOTTOM - (BOTTOM - TOP) * (v - low) / (high - low), 1)}"
        for t, v in zip((times - run.start_ns) / 1e9, values, strict=True)
    )
    drawing = zoomed(
        void("polyline", points=points),
        "line",
        (duration_s(run), HEIGHT),
        f"{chart.name} in {chart.unit}, from {number(low)} to {number(high)}",
    )
    labels = element("span", number(high, 2), class_="high") + element(
        "span", number(low, 2), class_="low"
    )
    head = element("h3", f"{chart.name} <small>{chart.unit}</small>")
    value = element("span", "", class_="value script")
    return element(
        "div",
        head + value + element("div", labels + drawing, class_="frame"),
        class_="chart",
        data_name=chart.name,
    )
