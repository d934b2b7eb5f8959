"""What the page's script is told: where the robot was, and what it saw, at which time."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from bt_mission.recording.model import RecordedRun
from bt_mission.views.html_report.charts import charts_of, thinned
from bt_mission.views.html_report.figures import duration_s, since_start_s
from bt_mission.views.html_report.plan import scans_on_map, spread
from bt_mission.views.html_report.timeline import rows_of

MOST_POSES = 3000
MOST_SCANS = 400
MOST_POINTS = 120
"""Of one scan."""


def script_data(run: RecordedRun) -> str:
    """The data as JSON that can stand inside a script element."""
    told = {
        "duration": round(duration_s(run), 3),
        "rows": [
            {
                "name": run.tree[row.node].name,
                "bars": [
                    [_s(run, span.start_ns), _s(run, span.end_ns), span.status, span.message]
                    for span, _ in row.bars
                ],
            }
            for row in rows_of(run)
        ],
        "poses": _poses(run),
        "scans": _scans(run),
        "charts": {
            chart.name: {
                "unit": chart.unit,
                "t": [_s(run, time_ns) for time_ns in times.tolist()],
                "v": np.round(values, 3).tolist(),
            }
            for chart in charts_of(run)
            for times, values in [thinned(chart)]
        },
    }
    return json.dumps(told, separators=(",", ":")).replace("<", "\\u003c")


def _s(run: RecordedRun, time_ns: int) -> float:
    return round(since_start_s(run, time_ns), 3)


def _poses(run: RecordedRun) -> dict[str, list[float]]:
    track = run.track
    chosen = spread(len(track), MOST_POSES)
    return {
        "t": [_s(run, int(time_ns)) for time_ns in track.times[chosen]],
        "x": np.round(track.x[chosen], 3).tolist(),
        "y": np.round(track.y[chosen], 3).tolist(),
        "yaw": np.round(np.degrees(track.yaw[chosen]), 1).tolist(),
    }


def _scans(run: RecordedRun) -> list[dict[str, Any]]:
    """Points on the map, in centimetres, x and y in turn."""
    told = []
    for time_ns, points in scans_on_map(run, MOST_SCANS):
        if len(points):
            chosen = points[spread(len(points), MOST_POINTS)]
            centimetres = np.round(chosen * 100).astype(int).ravel().tolist()
            told.append({"t": _s(run, time_ns), "p": centimetres})
    return told
