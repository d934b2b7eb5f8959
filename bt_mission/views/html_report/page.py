"""The page, put together."""

from __future__ import annotations

import json
from importlib.resources import files as package_files
from typing import Any

import numpy as np

from bt_mission.core.html.pages import POLICY
from bt_mission.core.text import escape_markup
from bt_mission.recording.model import RecordedRun
from bt_mission.views.html_report import tables
from bt_mission.views.html_report.figures import duration_s, since_start_s
from bt_mission.views.html_report.markup import element, rows
from bt_mission.views.html_report.plan import plan, scans_on_map, spread
from bt_mission.views.html_report.requirements import margin_charts, requirements
from bt_mission.views.html_report.timeline import charts, charts_of, rows_of, thinned, timeline

ASSETS = "bt_mission.views.html_report"

STATUS_WORDS = {
    "success": "succeeded",
    "failure": "failed",
    "interrupted": "was interrupted",
    "": "was not seen to start",
}


def page_of(run: RecordedRun) -> str:
    """A run as one page of HTML."""
    outcome = STATUS_WORDS.get(run.status, f"is {run.status}")
    title = f"{run.mission} {outcome}"
    reason = element("p", escape_markup(run.reason), class_="reason") if run.reason else ""
    badge = element("span", escape_markup(run.status or "unknown"), class_=f"badge {run.status}")
    head = element(
        "header",
        rows(
            [
                element("h1", f"{escape_markup(run.mission)} {badge}"),
                reason,
                tables.why(run),
                tables.warnings(run),
                tables.facts(run),
            ]
        ),
    )
    pictures = tables.pictures(run)
    style = _asset("bt_mission.core.html", "base.css") + _asset(ASSETS, "report.css")
    sections = [
        _section("Requirements", requirements(run)) if run.requirements else "",
        _section("Timeline", timeline(run)),
        _section("Where it went", plan(run)),
        _section("Figures", charts(run)),
        _section("Goals", tables.goals(run)),
        _section("Pictures", pictures) if pictures else "",
        _section("Leaves", tables.leaf_table(run)),
        _section("Log", tables.log(run)),
        _section("Mission file", tables.files(run)) if run.files else "",
        _section("Made with", tables.versions(run)),
    ]
    body = rows(
        [
            head,
            element("main", rows(sections)),
            f'<script type="application/json" id="run">{script_data(run)}</script>',
            element("script", _asset(ASSETS, "report.js")),
        ]
    )
    return rows(
        [
            "<!doctype html>",
            '<html lang="en">',
            "<head>",
            '<meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
            '<meta name="color-scheme" content="light dark">',
            element("title", escape_markup(title)),
            element("style", style),
            "</head>",
            element("body", body),
            "</html>",
            "",
        ]
    )


LONG_TABLE = 40
"""Rows; a longer table is folded."""


def _section(title: str, content: str) -> str:
    name = title.lower().replace(" ", "-")
    if (count := content.count("<tr>") - 1) > LONG_TABLE:
        content = element("details", element("summary", f"{count} rows") + content)
    return element("section", element("h2", title) + content, id=name)


def _asset(package: str, name: str) -> str:
    return (package_files(package) / name).read_text(encoding="utf-8")


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
                "depth": run.tree[row.node].depth,
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
            for chart in (*charts_of(run), *margin_charts(run))
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
