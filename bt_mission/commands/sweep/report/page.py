"""The page of a sweep, and what its template shows."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterator, Sequence
from copy import deepcopy
from importlib.resources import files as package_files
from itertools import groupby
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from bt_mission.base.errors import BtMissionError
from bt_mission.base.output import within, write_file
from bt_mission.base.text import cut, duration, number
from bt_mission.base.verdicts import FAILING
from bt_mission.commands.sweep.columns import WORST, SweepColumns
from bt_mission.commands.sweep.repeat import Repeater, parameters_as_text, resume_command
from bt_mission.commands.sweep.report.charts import (
    Figure,
    histogram_figure,
    pair_figure,
    success_figure,
)
from bt_mission.commands.sweep.report.explanation import Explainer
from bt_mission.commands.sweep.report.factors import factors_of, pairs_of
from bt_mission.commands.sweep.store import RECORDINGS, VERSIONS, ResultStore, SweepAbout
from bt_mission.commands.sweep.summary import percent, shown_verdicts, span
from bt_mission.scenarios.cause import KINDS
from bt_mission.scenarios.concrete.row import ScenarioRow
from bt_mission.scenarios.coverage.places import OUTCOME, REACHED, CoveragePlace
from bt_mission.scenarios.coverage.record import CoverageRecord
from bt_mission.views.html.pages import render

PAGE = "sweep.html"
MOST_MARGINS = 24
MOST_GROUPS = 50
MOST_PATH = 6
INSTALL = "the page of a sweep needs Plotly: pip install 'bt-mission[sweep]'"


def write_sweep_page(
    store: ResultStore,
    output: Path | None = None,
    *,
    worst: int = WORST,
    columns: SweepColumns | None = None,
) -> Path:
    """Generate the report of results; return its path.

    Args:
        output: The file; None is `sweep.html` among the results.
        worst: The number of the worst runs that are listed.
        columns: The columns of the rows, if they were read already.

    Raises:
        BtMissionError: Plotly is not installed, or the file cannot be written.
    """
    path = within(store.folder, PAGE) if output is None else output
    if columns is None:
        columns = SweepColumns(store.rows())
    write_file(path, SweepPage(store, columns).text(worst, path.parent))
    return path


def plotly_script() -> str:
    """Return Plotly's script, from its Python package.

    Raises:
        BtMissionError: It is not installed.
    """
    try:
        script = (package_files("plotly") / "package_data/plotly.min.js").read_text("utf-8")
    except (ModuleNotFoundError, FileNotFoundError) as error:
        raise BtMissionError(INSTALL, code="BT-905") from error
    return script.replace("</script", "<\\/script")


class SweepPage:
    """The parts of the page of results, as the template takes them.

    Args:
        store: Holds what the sweep is.
        columns: Of its rows.
    """

    def __init__(self, store: ResultStore, columns: SweepColumns) -> None:
        self._store = store
        self._columns = columns
        self._repeater = Repeater(store)
        self._figures: list[Figure] = []

    def text(self, worst: int, near: Path) -> str:
        """The page as HTML.

        Args:
            worst: The number of the worst runs that are listed.
            near: The folder that it will be in.

        Raises:
            BtMissionError: Where Plotly is not installed.
        """
        columns, tally, about = self._columns, self._columns.tally, self._store.about
        count, origin = tally.count, self._repeater.origin
        return render(
            "commands/sweep/report/sweep.html",
            plotly=plotly_script(),
            about=about,
            title=f"{about.mission}: {count.succeeded:,} of {count.scenarios:,} succeeded",
            count=count,
            facts={
                "succeeded": f"{count.succeeded:,}",
                "failed": f"{count.failed:,}",
                "could not run": f"{count.errors:,}",
                "orphaned goals": f"{tally.orphaned_goals:,}",
                "collisions": f"{tally.collisions:,}",
                "driven": _length(tally.distance_m),
                "time of the missions": duration(tally.virtual_s),
                "wall time, all workers": duration(tally.wall_s),
            },
            varied=list(_varied(about, columns)),
            factors=[
                (factor, self._drawn(f"Success by {factor.name}", success_figure(factor)))
                for factor in factors_of(columns)
            ],
            pairs=self._pairs(),
            failures=list(self._failures()),
            worst=[self._worst(row, near) for row in columns.worst_rows(self._store, worst)],
            requirements=list(self._requirements()),
            verdicts=shown_verdicts(tally.requirements.values()),
            failing=FAILING,
            **self._margins(),
            durations=self._durations(),
            coverage=self._coverage(origin.places if origin else ()),
            origin=origin,
            resume=resume_command(origin.command) if origin else "",
            versions=self._versions(),
            figures=self._figures,
            parameters_as_text=parameters_as_text,
            words=_words,
            percent=percent,
            span=span,
            number=number,
        )

    def _drawn(self, title: str, figure: Figure) -> dict[str, Any]:
        """Keep a figure for the script; return the data of its place."""
        self._figures.append(figure)
        place = {"number": len(self._figures) - 1, "height": figure["layout"]["height"]}
        return {"title": title, **place}

    def _pairs(self) -> tuple[list[dict[str, Any]], int]:
        pairs, left_out = pairs_of(self._columns)
        titles = (f"Success in % by {pair.first.name} and {pair.second.name}" for pair in pairs)
        drawn = zip(titles, map(pair_figure, pairs), strict=True)
        return [self._drawn(*titled) for titled in drawn], left_out

    def _failures(self) -> Iterator[tuple[str, list[dict[str, Any]], int]]:
        """Yield kinds of causes, the most frequent causes of each, and how many are omitted."""
        explainer = Explainer(self._columns)
        for kind, several in groupby(self._columns.tally.failures, lambda group: group.kind):
            of_kind = list(several)
            shown = [
                {
                    "group": group,
                    "way": _way(group.path),
                    "explanation": explainer.explain(group.cause),
                    "command": self._repeater.command(group.example),
                }
                for group in of_kind[:MOST_GROUPS]
            ]
            yield KINDS[kind].capitalize(), shown, len(of_kind) - len(shown)

    def _worst(self, row: ScenarioRow, near: Path) -> dict[str, Any]:
        """Return a row, the margin by which it is among the worst, and links to its recording."""
        name = self._columns.nearest(row)
        margin = None if name is None else row.requirements[name]
        least = "" if margin is None else f"{number(margin.margin or 0.0)} {margin.unit}".strip()
        links = []
        folder = self._store.folder / RECORDINGS
        for suffix, text in ((".html", "report"), (".mcap", "recording")):
            path = folder / f"{row.id}{suffix}"
            if path.is_file() and not path.is_symlink():
                links.append((quote(Path(os.path.relpath(path, near)).as_posix()), text))
        return {
            "row": row,
            "why": cut(row.why_failed, 140),
            "least": least,
            "requirement": name,
            "links": links,
            "command": self._repeater.command(row),
        }

    def _requirements(self) -> Iterator[tuple[str, Any, str, str, str]]:
        """Yield name, totals, interval, and the smallest and the median margin of each."""
        for name, requirement in self._columns.tally.requirements.items():
            margins = self._columns.margins(name)
            known = margins[np.isfinite(margins)]
            unit = requirement.unit if len(requirement.units) == 1 else ""
            middle = f"{number(float(np.median(known)))} {unit}" if len(known) else ""
            least = (
                ""
                if requirement.least is None
                else f"{number(requirement.least)} {requirement.unit}"
            )
            interval = "" if requirement.interval is None else span(*requirement.interval)
            yield name, requirement, interval, least, middle

    def _margins(self) -> dict[str, Any]:
        """Return charts of margins, and the names of requirements whose margin is always equal."""
        columns = self._columns
        drawn: list[dict[str, Any]] = []
        constant: list[str] = []
        for name, requirement in columns.tally.requirements.items():
            margins = columns.margins(name)
            known = margins[np.isfinite(margins)]
            if not len(known):
                continue
            if known.min() == known.max():
                constant.append(name)
            elif len(drawn) < MOST_MARGINS:
                units = " or ".join(sorted(filter(None, requirement.units)))
                axis = f"margin in {units}" if units else "margin"
                figure = histogram_figure(margins, columns.passed, axis, marks_zero=True)
                drawn.append(self._drawn(name, figure))
        return {"margins": drawn, "constant": constant}

    def _durations(self) -> dict[str, Any] | None:
        columns, ran = self._columns, self._columns.ran
        if not ran.any():
            return None
        seconds, passed = columns.seconds[ran], columns.passed[ran]
        figure = histogram_figure(seconds, passed, "time of the mission in s")
        return self._drawn("How long the missions took", figure)

    def _coverage(self, places: Sequence[CoveragePlace]) -> dict[str, Any] | None:
        """Return the coverage of all runs together; None if no run has recorded it."""
        bitmaps = {text: runs for text, runs in self._columns.coverage.items() if text}
        if not places or not bitmaps:
            return None
        record = CoverageRecord(deepcopy(places))
        for text, runs in bitmaps.items():
            try:
                record.add(text, runs)
            except ValueError as error:
                raise BtMissionError(
                    f"{self._store.folder}: column 'coverage': {error}", code="BT-714"
                ) from error
        total = sum(bitmaps.values())

        def share(runs: int) -> str:
            return "never" if not runs else "always" if runs == total else percent(runs / total)

        counts = [runs for place in record.places for runs in _ways(place).values()]
        return {
            "nodes": record.places,
            "ways": _ways,
            "total": total,
            "taken": sum(map(bool, counts)),
            "choices": len(counts),
            "never": [line for place in record.places for line in _never(place)],
            "share": share,
        }

    def _versions(self) -> list[str]:
        versions = []
        for fingerprint, runs in self._columns.versions.most_common():
            version = self._store.value(f"{VERSIONS} {fingerprint}") or fingerprint
            if version:
                is_alone = len(self._columns.versions) == 1
                versions.append(version if is_alone else f"{version} ({runs:,} runs)")
        return versions


def _varied(about: SweepAbout, columns: SweepColumns) -> Iterator[tuple[str, str]]:
    """Yield what was varied, and what was not."""
    for parameter in about.vary:
        name, _, values = parameter.partition("=")
        yield name, values.replace(",", ", ").replace("..", " to ")
    if about.plans:
        yield "plans of faults", ", ".join(about.plans)
    own = "its own for each draw" if about.sample else "that of the mission"
    yield "seeds", (about.seeds or own).replace("..", " to ")
    if about.sample:
        yield "draws", f"{about.sample:,}, by Latin hypercube"
    varied = {name.removeprefix("inputs.") for name in columns.values}
    inputs = about.scenario.get("inputs", {}).items()
    if fixed := [f"{name} = {value}" for name, value in inputs if name not in varied]:
        yield "inputs", ", ".join(fixed)


def _way(path: str) -> str:
    names = path.split(" > ") if path else []
    if len(names) > MOST_PATH:
        names = [names[0], "…", *names[2 - MOST_PATH :]]
    return " \u203a ".join(names)


def _ways(place: CoveragePlace) -> dict[str, int]:
    """Return the outcomes and branches of a node with the runs that have had them."""
    marks = {mark: runs for mark, runs in place.marks.items() if mark != REACHED}
    return {mark.removeprefix(OUTCOME): runs for mark, runs in marks.items()}


def _never(place: CoveragePlace) -> Iterator[str]:
    where = f"{place.name} ({place.label.removesuffix(place.name).strip()})"
    if not place.runs:
        yield where
    elif missing := [way for way, runs in _ways(place).items() if not runs]:
        yield f"{where}: {', '.join(missing)}"


def _words(command: str) -> list[str]:
    """Return a command as words, each quoted for the shell, between which a line may break."""
    try:
        split = shlex.split(command)
    except ValueError:  # a quotation mark without another: no line that a shell would take
        split = [command]
    return [word if word == "&&" else shlex.quote(word) for word in split]


def _length(metres: float) -> str:
    return f"{metres:,.0f} m" if metres < 10_000 else f"{metres / 1000:,.0f} km"
