"""Figures against time: small charts one below the other, on the timeline's axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bt_mission.recording.model import Floats, RecordedRun, Times
from bt_mission.views.html_report.figures import clearance, duration_s
from bt_mission.views.html_report.markup import element, hint, number, rows, void
from bt_mission.views.html_report.timeline import axis, zoomed

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
