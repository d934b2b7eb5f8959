"""The requirements of a run: what each came to, and its margin over time."""

from __future__ import annotations

import numpy as np

from bt_mission.core.text import escape_markup, seconds
from bt_mission.recording.model import RecordedRequirement, RecordedRun
from bt_mission.requirements.monitor import RequirementResult
from bt_mission.views.html_report.figures import duration_s
from bt_mission.views.html_report.markup import element, legend, number, rows, table, void
from bt_mission.views.html_report.timeline import HEIGHT, LineChart, axis, thinned, zoomed

TOP, BOTTOM = 8, 92
"""Where the greatest and the least margin lie."""
ALONE = "margin at each instant"
SO_FAR = "margin so far"
LEGEND = (("decides", "the instant that decides"), ("violated", "when the violation was noticed"))


def requirements(run: RecordedRun) -> str:
    """The whole section."""
    found = run.requirements
    lines = (_row(one.result) for one in found)
    drawn = [
        _drawing(run, one, chart)
        for one, chart in zip(found, _charts(run), strict=True)
        if chart is not None
    ]
    parts = [table(("requirement", "verdict", "margin", "decided at", ""), lines)]
    if drawn:
        parts += [*drawn, axis(duration_s(run)), legend("instant", LEGEND)]
    return rows(parts)


def margin_charts(run: RecordedRun) -> list[LineChart]:
    """Return the margins over time, of those requirements that have any."""
    return [chart for chart in _charts(run) if chart is not None]


def _charts(run: RecordedRun) -> list[LineChart | None]:
    return [_chart(run, index, one) for index, one in enumerate(run.requirements)]


def _chart(run: RecordedRun, index: int, one: RecordedRequirement) -> LineChart | None:
    has_margin = np.isfinite(one.margins)
    if not has_margin.any():
        return None
    times = run.start_ns + np.round(one.times[has_margin] * 1e9).astype(np.int64)
    return LineChart(f"requirement {index}", one.result.unit, times, one.margins[has_margin])


def _row(result: RequirementResult) -> str:
    text = element("div", escape_markup(result.requirement), class_="formula")
    verdict = element("span", escape_markup(result.verdict), class_=f"verdict {result.verdict}")
    cells = [
        element("b", escape_markup(result.name)) + text,
        verdict,
        "" if result.margin is None else escape_markup(f"{result.margin:.4g} {result.unit}"),
        "" if result.at is None else seconds(result.at),
        escape_markup(_remark(result)),
    ]
    return element("tr", "".join(element("td", cell) for cell in cells))


def _remark(result: RequirementResult) -> str:
    if result.violated_at is not None:
        return f"noticed at {seconds(result.violated_at)}"
    return result.why


def _drawing(run: RecordedRun, one: RecordedRequirement, chart: LineChart) -> str:
    result = one.result
    low = min(0.0, float(chart.values.min()))
    high = max(0.0, float(chart.values.max()))
    if high - low < 1e-6:
        high = low + 1.0

    def y(margin: float) -> float:
        return BOTTOM - (BOTTOM - TOP) * (margin - low) / (high - low)

    times, values = thinned(chart)
    points = " ".join(
        f"{number(t, 2)},{number(y(v), 1)}"
        for t, v in zip((times - run.start_ns) / 1e9, values, strict=True)
    )
    duration = duration_s(run)
    below = void("rect", class_="below", x=0, y=y(0.0), width=duration, height=HEIGHT - y(0.0))
    what = ALONE if one.is_of_instants else SO_FAR
    unit = f" in {chart.unit}" if chart.unit else ""
    drawing = zoomed(
        below + void("polyline", points=points) + _instants(result),
        "line margin",
        (duration, HEIGHT),
        f"{result}. The {what}{unit} goes from {number(low)} to {number(high)}; "
        "below 0 it is violated",
    )
    labels = rows(
        element("span", number(value, 2), style=f"top:{number(y(value), 1)}px")
        for value in (high, 0.0, low)
        if value == 0 or abs(y(value) - y(0.0)) > TOP
    )
    small = element("small", escape_markup(f"{what}{f', {chart.unit}' if chart.unit else ''}"))
    return element(
        "div",
        element("h3", f"{escape_markup(result.name)} {small}")
        + element("span", "", class_="value script")
        + element("div", labels + drawing, class_="frame"),
        class_="chart margins",
        data_name=chart.name,
    )


def _instants(result: RequirementResult) -> str:
    """Mark the instant that decides, and that of the violation."""
    marks = (("violated", "violated", result.violated_at), ("decides", "decided", result.at))
    return "".join(
        element(
            "line",
            element("title", f"{word} at {seconds(time_s)}"),
            class_=f"instant {name}",
            x1=time_s,
            x2=time_s,
            y1=0,
            y2=HEIGHT,
        )
        for name, word, time_s in marks
        if time_s is not None
    )
