"""Missions and their results in Jupyter: what a cell shows of them.

IPython asks for the formatter of an object by the names of its module and its type, so that nothing
is imported before a cell shows it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from bt_mission.base.commands import loaded, points
from bt_mission.base.text import escape_markup, escape_page, lines_of

if TYPE_CHECKING:
    from bt_mission.executive.report import Report
    from bt_mission.language.mission import Mission
    from bt_mission.recording.model import RecordedRun

SVG, HTML = "image/svg+xml", "text/html"
HEIGHT_PX = 640
"""The height of a page in a cell."""


@dataclass(frozen=True)
class Display:
    """What a cell shows of a type: its media type, and the function that makes it."""

    media_type: str
    make: Callable[[Any], str]


def show_richly() -> None:
    """Register the displays with IPython, if it runs; a second call changes nothing."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    if shell is None:
        return
    added = {name: _added(target) for name, target in points("display.").items()}
    for name, display in {**DISPLAYS, **added}.items():
        module, _, type_name = name.rpartition(".")
        formatter = shell.display_formatter.formatters[display.media_type]
        formatter.for_type_by_name(module, type_name, display.make)


def _tree(mission: Mission) -> str:
    from bt_mission.views.drawing.nodes import drawn, heading
    from bt_mission.views.drawing.scene import scene
    from bt_mission.views.drawing.svg import svg

    return svg(scene(drawn(mission), heading(mission)))


def _report(report: Report) -> str:
    first, *facts = lines_of(report.as_text())
    rows = "".join(
        f"<tr><td>{escape_markup(each.name)}</td><td>{escape_markup(each.outcome)}</td></tr>"
        for each in report.requirements
    )
    table = f"<table><tr><th>requirement</th><th>verdict</th></tr>{rows}</table>" if rows else ""
    lines = [each for each in facts if not each.startswith("  requirement ")]
    text = "<br>".join(escape_markup(each.strip()) for each in lines)
    return f"<p><b>{escape_markup(first)}</b><br>{text}</p>{table}"


def _recording(run: RecordedRun) -> str:
    from bt_mission.views.web.report.page import page_of, robot_runs

    return _frame(page_of(list(robot_runs(run.path))))


def _added(target: str) -> Display:
    """Return what a cell shows of a type of a command: a page in a frame."""
    return Display(HTML, lambda shown: _frame(loaded(target)(shown)))


def _frame(page: str) -> str:
    # With an origin of its own: its scripts reach neither the notebook nor the network.
    return (
        f'<iframe sandbox="allow-scripts" width="100%" height="{HEIGHT_PX}" '
        f'style="border: 0" srcdoc="{escape_page(page)}"></iframe>'
    )


DISPLAYS: Mapping[str, Display] = {
    "bt_mission.language.mission.Mission": Display(SVG, _tree),
    "bt_mission.executive.report.Report": Display(HTML, _report),
    "bt_mission.recording.model.RecordedRun": Display(HTML, _recording),
}
"""By the name of the type; commands add more."""
