"""The parts of the page that are text and tables."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from bt_mission.core.text import duration, escape_markup
from bt_mission.scenarios.cause import KINDS
from bt_mission.sweeps.origin import SweepOrigin, resume_command
from bt_mission.sweeps.repeat import Repeater, told_parameters
from bt_mission.sweeps.report.columns import SweepColumns
from bt_mission.sweeps.report.explanation import Explainer, Explanation
from bt_mission.sweeps.report.factors import Level
from bt_mission.sweeps.report.markup import command_line, line
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.summary import FailureGroup, percent, span
from bt_mission.sweeps.worst import WorstRows
from bt_mission.views.html_report.markup import element, hint, number, rows, table

MOST_GROUPS = 50
MOST_PATH = 6
ARROW = " \u203a "
RECORDINGS = "recordings"
"""The folder of the results for recordings of single scenarios, named by their ids."""


def facts(columns: SweepColumns) -> str:
    """Return the figures of the head."""
    tally = columns.tally
    count = tally.count
    told = {
        "succeeded": f"{count.succeeded:,}",
        "failed": f"{count.failed:,}",
        "could not run": f"{count.errors:,}",
        "orphaned goals": f"{tally.orphaned_goals:,}",
        "collisions": f"{tally.collisions:,}",
        "driven": _length(tally.distance_m),
        "time of the missions": duration(tally.virtual_s),
        "wall time, all workers": duration(tally.wall_s),
    }
    cells = (
        element("div", element("dt", name) + element("dd", value)) for name, value in told.items()
    )
    return element("dl", rows(cells), class_="facts")


def varied_table(about: Mapping[str, Any], columns: SweepColumns) -> str:
    """Return what was varied, and what was not."""
    lines = []
    for told in about.get("vary", ()):
        name, _, values = str(told).partition("=")
        lines.append((name, values.replace(",", ", ").replace("..", " to ")))
    if about.get("plans"):
        lines.append(("plans of faults", ", ".join(about["plans"])))
    seeds = about.get("seeds")
    own = "its own for each draw" if about.get("sample") else "that of the mission"
    lines.append(("seeds", str(seeds or own).replace("..", " to ")))
    if about.get("sample"):
        lines.append(("draws", f"{about['sample']:,}, by Latin hypercube"))
    inputs = about.get("scenario", {}).get("inputs", {})
    varied = {name.removeprefix("inputs.") for name in columns.values}
    if fixed := {name: value for name, value in inputs.items() if name not in varied}:
        lines.append(("inputs", ", ".join(f"{name} = {value}" for name, value in fixed.items())))
    return element(
        "div",
        element(
            "table",
            rows(
                element("tr", element("th", escape_markup(name), scope="row") + _cell(value))
                for name, value in lines
            ),
        ),
        class_="scroll varied",
    )


def _cell(text: str) -> str:
    return element("td", escape_markup(text))


def levels_table(name: str, levels: Sequence[Level]) -> str:
    """Return the figures of a chart of success, folded up."""
    content = table(
        (escape_markup(name), "succeeded", "distinct", "share", "95 %"),
        (
            line(
                (
                    escape_markup(one.label),
                    f"{one.passed:,} of {one.total:,}",
                    f"{one.total if one.samples is None else one.samples:,}",
                    percent(one.rate),
                    span(*one.interval),
                )
            )
            for one in levels
        ),
    )
    return element("details", element("summary", "as a table") + content)


def failures(columns: SweepColumns, repeater: Repeater) -> str:
    """Return the causes of what has not passed, each with an example, under their kinds."""
    groups = columns.tally.failures
    if not groups:
        return hint("Every scenario has succeeded.")
    total = columns.tally.count.scenarios
    explainer = Explainer(columns)
    parts: list[str] = []
    for kind, several in groupby(groups, lambda one: one.kind):
        of_kind = list(several)
        shown = rows(
            _failure(one, total, repeater, explainer.explain(one.cause))
            for one in of_kind[:MOST_GROUPS]
        )
        left = len(of_kind) - MOST_GROUPS
        more = f"{left} more causes are in the output of sweep-report --json." if left > 0 else ""
        heading = element("h3", KINDS[kind].capitalize())
        parts += [heading, element("ol", shown, class_="failures") + hint(more)]
    return rows(parts)


def _failure(
    one: FailureGroup, total: int, repeater: Repeater, explanation: Explanation | None
) -> str:
    head = element("b", f"{one.count:,}") + " "
    if one.path:
        head += element("span", escape_markup(one.node), class_="leaf")
    head += element("small", f"{percent(one.count / total)} of all")
    example = (
        f"For example scenario {one.example.number}: {told_parameters(one.example)}, "
        f"after {number(one.example.virtual_s, 2)} s"
    )
    return element(
        "li",
        rows(
            [
                element("p", head, class_="count"),
                element("p", escape_markup(one.reason), class_="why"),
                _way(one.path),
                element("p", escape_markup(f"{explanation}."), class_="explained")
                if explanation
                else "",
                element("p", escape_markup(example), class_="hint"),
                command_line(repeater.command(one.example)),
            ]
        ),
    )


def _way(path: str) -> str:
    names = path.split(" > ") if path else []
    if len(names) > MOST_PATH:
        names = [names[0], "…", *names[2 - MOST_PATH :]]
    return element("p", escape_markup(ARROW.join(names)), class_="hint way") if names else ""


def worst_table(
    worst: Sequence[ScenarioRow],
    found: WorstRows,
    folder: Path,
    repeater: Repeater,
    near: Path | None = None,
) -> str:
    """Return the worst runs, with links to what is recorded of them.

    Args:
        found: Has found them.
        folder: Of the results.
        near: The folder of the page; None is that of the results.
    """
    if not worst:
        return hint("No scenario could run.")
    lines = (
        line(
            (
                f"{row.number}<small>{escape_markup(row.id)}</small>",
                _outcome(row),
                escape_markup(told_parameters(row)),
                _least(row, found),
                f"{number(row.virtual_s, 2)} s",
                _links(row, folder, near or folder) + command_line(repeater.command(row)),
            ),
            ("", "outcome", "values", "margin", "time", "repeat"),
            id=f"scenario-{row.id}",
        )
        for row in worst
    )
    return table(
        ("scenario", "outcome", "values", "smallest margin", "time", "see it, repeat it"),
        lines,
        "scroll worst",
    )


def _outcome(row: ScenarioRow) -> str:
    name = "success" if row.passed else "failure"
    told = "succeeded" if row.passed else row.why_failed
    return element("span", "", class_=f"dot {name}") + escape_markup(_cut(told, 140))


def _least(row: ScenarioRow, found: WorstRows) -> str:
    """The margin by which a run is among the worst."""
    name = found.nearest(row)
    if name is None:
        return ""
    one = row.requirements[name]
    assert one.margin is not None, "it has counted"
    told = escape_markup(f"{number(one.margin)} {one.unit}".strip())
    return f"{told}<small>{escape_markup(name)}</small>"


def _links(row: ScenarioRow, folder: Path, near: Path) -> str:
    links = []
    recordings = Path(os.path.relpath(folder / RECORDINGS, near)).as_posix()
    for suffix, text in ((".html", "report"), (".mcap", "recording")):
        path = folder / RECORDINGS / f"{row.id}{suffix}"
        if path.is_file() and not path.is_symlink():
            links.append(element("a", text, href=quote(f"{recordings}/{row.id}{suffix}")))
    return element("p", " · ".join(links), class_="links") if links else ""


def requirements_table(columns: SweepColumns) -> str:
    """Return what became of each requirement."""
    lines = []
    for name, one in columns.tally.requirements.items():
        margins = columns.margins(name)
        known = margins[np.isfinite(margins)]
        unit = one.unit if len(one.units) == 1 else ""
        middle = f"{number(float(np.median(known)))} {unit}" if len(known) else ""
        least = "" if one.least is None else f"{number(one.least)} {one.unit}"
        counts = [f"{one.verdicts[key]:,}" for key in ("holds", "violated", "open", "unknown")]
        violated = "violated" if one.verdicts["violated"] else ""
        lines.append(
            line(
                map(escape_markup, (name, *counts, least, middle, one.example)),
                ("", "", f"verdict {violated}".strip(), "", "", "", "", "id"),
            )
        )
    head = ("requirement", "holds", "violated", "open", "unknown", "smallest margin")
    return table((*head, "median", "smallest in"), lines)


def made_with(about: Mapping[str, Any], origin: SweepOrigin | None, versions: Sequence[str]) -> str:
    """Return what the sweep was made with, and how it is gone on with."""
    lines = []
    if origin is not None and origin.command:
        lines += [
            hint("The sweep again, or on with it where it was stopped:"),
            command_line(resume_command(origin.command)),
        ]
    lines += [
        element("p", escape_markup(f"Versions: {one}"), class_="versions") for one in versions
    ]
    if digest := about.get("mission_hash"):
        told = f"Files of the mission, its worlds and robots (SHA-256): {digest}"
        lines.append(element("p", escape_markup(told), class_="hint"))
    if origin is not None:
        text = origin.bundle.files.get(origin.bundle.mission, "")
        summary = element("summary", escape_markup(origin.path))
        lines.append(element("details", summary + element("pre", escape_markup(text))))
    return rows(lines)


def _cut(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most - 1]}…"


def _length(metres: float) -> str:
    return f"{metres:,.0f} m" if metres < 10_000 else f"{metres / 1000:,.0f} km"
