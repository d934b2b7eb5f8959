"""Figures of a sweep, as data for Plotly.

Plotly takes tags such as ``<b>`` and ``<a href>`` in texts for markup, and ``%{...}`` in templates
for values: every text of others goes through :func:`plain`, and no template contains one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from bt_mission.base.text import cut, escape_control, escape_markup
from bt_mission.commands.sweep.columns import Flags, Floats
from bt_mission.commands.sweep.report.factors import Factor, Level, Pair, round_edges, short
from bt_mission.commands.sweep.summary import percent, span

Figure: TypeAlias = dict[str, Any]

# Distinguishable with any colour vision, on a light and on a dark ground; the page's style sheet
# has the rest.
PASSED, FAILED, CURVE = "#2f86c9", "#d9603b", "#2f86c9"
BAND = "rgba(47, 134, 201, 0.25)"
RATES = ((0.0, "#b5402a"), (0.5, "#f2e3c4"), (1.0, "#2f7fb8"))
HATCHED = {
    "shape": "/",
    "fillmode": "overlay",
    "fgcolor": "#ffffff",
    "fgopacity": 0.5,
    "size": 6,
    "solidity": 0.2,
}
BINS = 40
MOST_LETTERS = 24


def plain(text: str, most: int = 300) -> str:
    """Return a text that Plotly shows unchanged, cut after a number of characters."""
    return escape_markup(cut(escape_control(text), most))


def success_figure(factor: Factor) -> Figure:
    """Return success by a parameter: a curve over numbers, bars for names."""
    return _curve(factor) if factor.is_number else _bars(factor)


def _curve(factor: Factor) -> Figure:
    at = [level.at for level in factor.levels]
    low, high = zip(*(level.interval for level in factor.levels), strict=True)
    edge = {
        "type": "scatter",
        "x": at,
        "mode": "lines",
        "line": {"width": 0},
        "hoverinfo": "skip",
        "showlegend": False,
    }
    return _figure(
        [
            {**edge, "y": list(high)},
            {**edge, "y": list(low), "fill": "tonexty", "fillcolor": BAND},
            {
                "type": "scatter",
                "x": at,
                "y": [level.rate for level in factor.levels],
                "mode": "lines+markers",
                "line": {"color": CURVE, "width": 2},
                "marker": {"size": 7},
                "text": [_level_text(level) for level in factor.levels],
                "hovertemplate": "%{text}<extra></extra>",
                "showlegend": False,
            },
        ],
        x={"title": _title(factor.name)},
        y=_share_axis(factor.levels),
    )


def _bars(factor: Factor) -> Figure:
    rates = [level.rate for level in factor.levels]
    low, high = zip(*(level.interval for level in factor.levels), strict=True)
    bars = {
        "type": "bar",
        "orientation": "h",
        "x": rates,
        "y": list(range(len(rates))),
        "width": 0.6,
        "marker": {"color": PASSED},
        "error_x": {
            "type": "data",
            "symmetric": False,
            "array": [top - rate for top, rate in zip(high, rates, strict=True)],
            "arrayminus": [rate - bottom for bottom, rate in zip(low, rates, strict=True)],
            "color": "#7d8794",
        },
        "text": [_level_text(level) for level in factor.levels],
        "textposition": "none",
        "hovertemplate": "%{text}<extra></extra>",
    }
    y = {**_names(factor.levels), "range": [len(rates) - 0.5, -0.5]}
    return _figure([bars], x={**_share_axis(()), "range": [0, 1.02]}, y=y, rows=len(rates))


def pair_figure(pair: Pair) -> Figure:
    """Return success by two parameters, as a map with the shares in its cells."""
    rates = np.where(pair.total > 0, pair.passed / np.maximum(pair.total, 1), np.nan)
    cells, hover_texts = [], []
    for row in range(rates.shape[0]):
        cells.append([_share(value) for value in rates[row]])
        hover_texts.append([_cell_text(pair, row, column) for column in range(rates.shape[1])])
    least = next(at for at in (0.9, 0.5, 0.0) if np.nanmin(rates) >= at)
    heat = {
        "type": "heatmap",
        "z": [[None if np.isnan(rate) else float(rate) for rate in row] for row in rates],
        "zmin": least,
        "zmax": 1,
        "colorscale": RATES,
        "text": cells,
        "texttemplate": "%{text}",
        "customdata": hover_texts,
        "hovertemplate": "%{customdata}<extra></extra>",
        "xgap": 2,
        "ygap": 2,
        "colorbar": {
            "tickformat": ".0%",
            "thickness": 10,
            "outlinewidth": 0,
            "nticks": 5,
            "len": 0.9,
        },
    }
    first, second = pair.first, pair.second
    return _figure(
        [heat],
        x={**_names(first.levels), "title": _title(first.name)},
        y={**_names(second.levels), "title": _title(second.name)},
        rows=max(5, len(second.levels)),
    )


def _cell_text(pair: Pair, row: int, column: int) -> str:
    first, second = pair.first.levels[column], pair.second.levels[row]
    total, passed = int(pair.total[row, column]), int(pair.passed[row, column])
    where = (
        f"{plain(pair.first.name)} {plain(first.label)}<br>"
        f"{plain(pair.second.name)} {plain(second.label)}"
    )
    if not total:
        return f"{where}<br>no scenario"
    samples = int(pair.samples[row, column])
    return f"{where}<br>{_count_text(Level('', 0.0, passed, total, samples))}"


def histogram_figure(
    values: Floats, passed: Flags, axis: str, *, marks_zero: bool = False
) -> Figure:
    """Return the histogram of values, those of failed runs on top of the others.

    Args:
        values: NaN for a run without one.
        passed: Whether each run passed.
        axis: The title of the values, with their unit.
        marks_zero: Draw a line at 0, below which a requirement is violated.
    """
    is_known = np.isfinite(values)
    known = values[is_known]
    edges = round_edges(known.min(), known.max(), min(BINS, max(12, int(len(known) ** 0.5))))
    traces = []
    for name, chosen, colour, pattern in (
        ("succeeded", passed[is_known], PASSED, {}),
        ("failed", ~passed[is_known], FAILED, HATCHED),
    ):
        counts, _ = np.histogram(known[chosen], edges)
        if not counts.any():
            continue
        hover_texts = [
            f"{short(low)} to {short(high)}: {count:,} {name}"
            for low, high, count in zip(edges[:-1], edges[1:], counts.tolist(), strict=True)
        ]
        traces.append(
            {
                "type": "bar",
                "name": name,
                "x": _rounded((edges[1:] + edges[:-1]) / 2),
                "y": counts.tolist(),
                "width": _rounded(np.diff(edges)),
                "marker": {"color": colour, "pattern": pattern},
                "text": hover_texts,
                "textposition": "none",
                "hovertemplate": "%{text}<extra></extra>",
                "showlegend": True,
            }
        )
    layout: dict[str, Any] = {"barmode": "stack", "bargap": 0}
    if marks_zero:
        line = {"color": "#7d8794", "width": 2, "dash": "dot"}
        layout["shapes"] = [
            {"type": "line", "x0": 0, "x1": 0, "yref": "paper", "y0": 0, "y1": 1, "line": line}
        ]
    return _figure(
        traces,
        x={"title": _title(axis)},
        y={"title": _title("scenarios"), "rangemode": "tozero", "tickformat": "~s"},
        more=layout,
    )


def _figure(
    traces: Sequence[Figure],
    x: dict[str, Any],
    y: dict[str, Any],
    *,
    rows: int = 0,
    more: dict[str, Any] | None = None,
) -> Figure:
    """Return a figure; one with a row for each of several levels grows with them."""
    axis = {"automargin": True, "zeroline": False, "fixedrange": True}
    return {
        "data": list(traces),
        "layout": {
            "height": max(260, 90 + 30 * rows),
            "margin": {"l": 44, "r": 14, "t": 12, "b": 40},
            "paper_bgcolor": "rgba(0,0,0,0)",
            "plot_bgcolor": "rgba(0,0,0,0)",
            "font": {"size": 12, "family": "system-ui, DejaVu Sans, sans-serif"},
            "legend": {"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0},
            "hoverlabel": {"align": "left"},
            "xaxis": {**axis, **x},
            "yaxis": {**axis, **y},
            **(more or {}),
        },
    }


def _share_axis(levels: Sequence[Level]) -> dict[str, Any]:
    """The axis of success: from 0, or closer where all levels are high, so that they differ."""
    least = min((level.interval[0] for level in levels), default=0.0)
    bottom = next(at for at in (0.9, 0.5, 0.0) if least >= at)
    return {"tickformat": ".0%", "range": [bottom - 0.02 * (1 - bottom), 1 + 0.02 * (1 - bottom)]}


def _title(name: str) -> dict[str, Any]:
    return {"text": plain(name, MOST_LETTERS), "standoff": 10}


def _names(levels: Sequence[Level]) -> dict[str, Any]:
    return {
        "tickmode": "array",
        "tickvals": list(range(len(levels))),
        "ticktext": [plain(level.label, MOST_LETTERS) for level in levels],
        "showgrid": False,
        "ticks": "outside",
        "ticklen": 5,
        "tickcolor": "rgba(0,0,0,0)",
    }


def _level_text(level: Level) -> str:
    return f"{plain(level.label)}<br>{_count_text(level)}"


def _count_text(level: Level) -> str:
    distinct = "" if level.samples in (None, level.total) else f", {level.samples:,} distinct"
    return (
        f"{level.passed:,} of {level.total:,}{distinct}: {percent(level.rate)}<br>"
        f"({span(*level.interval)} at 95 %)"
    )


def _share(value: float) -> str:
    """Return a share in whole per cent; only all is 100, and only none is 0."""
    if np.isnan(value):
        return ""
    return f"{value * 100:.0f}" if value in (0, 1) else f"{min(max(value * 100, 1), 99):.0f}"


def _rounded(values: Floats) -> list[float]:
    """Values with the digits that a picture needs."""
    return [float(f"{value:.6g}") for value in values.tolist()]
