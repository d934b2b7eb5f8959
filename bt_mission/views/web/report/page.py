"""The page of a recorded run, in one file: markup, style, script, and the data compressed."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from markupsafe import Markup

from bt_mission.base.output import write_file
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.recording.robots import recorded_robots
from bt_mission.recording.verification import read_verified_run
from bt_mission.views.html.pages import render
from bt_mission.views.web.encoding import shown
from bt_mission.views.web.report.details import details
from bt_mission.views.web.report.history import ReportHistory

PAGE = Path(__file__).resolve().parents[1] / "page"

POLICY = (
    "default-src 'none'; script-src 'sha256-{script}'; style-src 'sha256-{style}'; img-src data:; "
    "base-uri 'none'; form-action 'none'"
)
"""Nothing is fetched, and nothing runs but the script of the page."""

_IMPORT = re.compile(r'^import \{([^}]*)\} from "\./(\w+\.js)";$', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:const|function|class) (\w+))", re.MULTILINE)


@dataclass(frozen=True)
class RobotRun:
    """The run of one robot on a page: its name, the state at the end, and the data.

    `data` may also have: `at`, s, where the page opens it instead of at its end; the `speed` at
    which it plays; and of `fork` the `command` on a terminal, up to that instant, or the `refusal`
    of a run that cannot run again.
    """

    robot: str
    mission: MissionState
    data: dict[str, Any]

    @property
    def packed(self) -> bytes:
        """The data as compressed JSON."""
        text = json.dumps(self.data, separators=(",", ":"), allow_nan=False)
        return gzip.compress(text.encode(), 6, mtime=0)


def write_report(recording: Path, output: Path, robot: str | None = None) -> None:
    """Generate the report of a recording.

    Args:
        robot: Of several robots, the only one in the report; None shows all.

    Raises:
        BtMissionError: The file has no run, or the report cannot be written.
    """
    write_file(output, page_of(list(robot_runs(recording, robot))))


def page_of(runs: Sequence[RobotRun]) -> str:
    """Return the page of the robots of a recording, in one file; the first is shown first."""
    style, script = _text("style.css"), bundled("app.js")
    return _page(
        runs,
        icon=base64.b64encode(_text("icon.svg").encode()).decode(),
        policy=POLICY.format(script=_hash(script), style=_hash(style)),
        style=Markup(style),  # noqa: S704 - a file of ours
        script=Markup(script),  # noqa: S704 - files of ours
    )


def served_page_of(runs: Sequence[RobotRun]) -> str:
    """Return the same page with references to its style and its script, for a server of them."""
    return _page(runs)


def _page(runs: Sequence[RobotRun], **inlined: str) -> str:
    mission = runs[0].mission
    verdict, reason = mission.conclusion
    content = {
        "title": mission.tree.mission if mission.tree else "no mission",
        "status": verdict or "unknown",
        "reason": reason,
        "runs": [(run.robot, base64.b64encode(run.packed).decode()) for run in runs],
    }
    return render("views/web/page/index.html", report={**content, **inlined})


def robot_runs(recording: Path, robot: str | None = None) -> Iterator[RobotRun]:
    """Yield the run of each robot in a recording; errors as :func:`write_report`."""
    robots: Sequence[str | None] = [robot] if robot is not None else recorded_robots(recording)
    for name in robots if len(robots) > 1 else [robot]:
        run, timeline = read_verified_run(recording, name)
        history = ReportHistory(timeline)
        data = {
            **history.data(),
            "source": shown(recording.name),
            "cut": shown(timeline.why_cut),
            "missing": shown(timeline.missing),
            "details": details(run, history.mission),
        }
        yield RobotRun(name or "", history.mission, data)


@cache
def bundled(entry: str) -> str:
    """Return a module of the page, with all its imports, as one script.

    Each module is a function that returns what it exports: a page in one file has no addresses from
    which modules could import.
    """
    made: dict[str, str] = {}

    def add(name: str) -> None:
        if name in made:
            return
        source = _text(name)
        for _, imported in _IMPORT.findall(source):
            add(imported)
        exported = ", ".join(_EXPORT.findall(source))
        source = _IMPORT.sub(r'const {\1} = modules["\2"];', _EXPORT.sub("", source))
        made[name] = f'modules["{name}"] = (() => {{\n{source}\nreturn {{ {exported} }};\n}})();\n'

    add(entry)
    return '"use strict";\nconst modules = {};\n' + "".join(made.values())


def _text(name: str) -> str:
    return (PAGE / name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
