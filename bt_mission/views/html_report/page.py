"""The page, put together."""

from __future__ import annotations

from html import escape
from importlib.resources import files as package_files

from bt_mission.recording.model import RecordedRun
from bt_mission.views.html_report import tables
from bt_mission.views.html_report.charts import charts
from bt_mission.views.html_report.data import script_data
from bt_mission.views.html_report.markup import element, rows
from bt_mission.views.html_report.plan import plan
from bt_mission.views.html_report.timeline import timeline

# Nothing may be fetched: whatever is named here comes out of the page itself.
POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"

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
    reason = element("p", escape(run.reason), class_="reason") if run.reason else ""
    badge = element("span", escape(run.status or "unknown"), class_=f"badge {run.status}")
    head = element(
        "header",
        rows(
            [
                element("h1", f"{escape(run.mission)} {badge}"),
                reason,
                tables.why(run),
                tables.warnings(run),
                tables.facts(run),
            ]
        ),
    )
    pictures = tables.pictures(run)
    sections = [
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
            element("script", _asset("report.js")),
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
            element("title", escape(title)),
            element("style", _asset("report.css")),
            "</head>",
            element("body", body),
            "</html>",
            "",
        ]
    )


def _section(title: str, content: str) -> str:
    name = title.lower().replace(" ", "-")
    return element("section", element("h2", title) + content, id=name)


def _asset(name: str) -> str:
    return (package_files("bt_mission.views.html_report") / name).read_text(encoding="utf-8")
