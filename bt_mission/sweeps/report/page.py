"""The page of a sweep, put together."""

from __future__ import annotations

import json
from importlib.resources import files as package_files
from pathlib import Path
from typing import Any

import numpy as np

from bt_mission.core.errors import BtMissionError
from bt_mission.core.html.pages import POLICY
from bt_mission.core.output import write_file
from bt_mission.core.text import escape_markup
from bt_mission.sweeps.folder import within
from bt_mission.sweeps.repeat import Repeater
from bt_mission.sweeps.report import sections
from bt_mission.sweeps.report.charts import (
    Figure,
    histogram_figure,
    pair_figure,
    success_figure,
)
from bt_mission.sweeps.report.columns import SweepColumns
from bt_mission.sweeps.report.coverage import coverage_section
from bt_mission.sweeps.report.factors import factors_of, pairs_of
from bt_mission.sweeps.store import ResultStore
from bt_mission.sweeps.summary import percent, span
from bt_mission.sweeps.worst import WORST, rows_of
from bt_mission.views.html_report.markup import element, hint, rows

PAGE = "sweep.html"
MOST_MARGINS = 24
INSTALL = "the page of a sweep is drawn by Plotly: pip install 'bt-mission[sweep]'"
VERSIONS = "versions"


def write_sweep_page(
    store: ResultStore,
    output: Path | None = None,
    *,
    worst: int = WORST,
    columns: SweepColumns | None = None,
) -> Path:
    """Make the page of results; return where it is.

    Args:
        output: The file; None is `sweep.html` among the results.
        worst: So many of the worst runs are told of.
        columns: Of the rows, where they are read already.

    Raises:
        BtMissionError: Where Plotly is not installed, or the file cannot be written.
    """
    path = within(store.folder, PAGE) if output is None else output
    if columns is None:
        columns = SweepColumns.of(store.rows())
    page = SweepPage(store, columns, worst).text(path.parent)
    write_file(path, page)
    return path


class SweepPage:
    """The page of results.

    Args:
        store: Holds what the sweep is.
        columns: Of its rows.
        worst: So many of the worst runs are told of.
    """

    def __init__(self, store: ResultStore, columns: SweepColumns, worst: int = WORST) -> None:
        self._store = store
        self._columns = columns
        self._worst = worst
        self._about = store.about
        self._repeater = Repeater(store)
        self._figures: list[Figure] = []

    def text(self, near: Path | None = None) -> str:
        """The page as HTML.

        Args:
            near: The folder that it will be in; None is that of the results.

        Raises:
            BtMissionError: Where Plotly is not installed.
        """
        plotly = plotly_script()
        places = self._repeater.origin.places if self._repeater.origin else ()
        coverage = coverage_section(self._columns, places)
        worst = rows_of(self._store, self._columns.worst.ids(self._worst))
        parts = [
            ("What was varied", sections.varied_table(self._about, self._columns)),
            ("Success", self._success()),
            ("Failures", sections.failures(self._columns, self._repeater)),
            (
                "The worst",
                sections.worst_table(
                    worst, self._columns.worst, self._store.folder, self._repeater, near
                ),
            ),
            ("Requirements", self._requirements()),
            ("Duration", self._duration()),
            ("Coverage of the tree", coverage),
            (
                "Made with",
                sections.made_with(self._about, self._repeater.origin, self._versions()),
            ),
        ]
        shown = [_section(title, content) for title, content in parts if content]
        # No "<", so that no text in it can end the element.
        figures = json.dumps(self._figures, separators=(",", ":")).replace("<", "\\u003c")
        body = rows(
            [
                self._head(),
                element("main", rows(shown)),
                f'<script type="application/json" id="figures">{figures}</script>',
                element("script", plotly),
                element("script", _asset("bt_mission.sweeps.report", "sweep.js")),
            ]
        )
        style = _asset("bt_mission.core.html", "base.css") + _asset(
            "bt_mission.sweeps.report", "sweep.css"
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
                element("title", escape_markup(self._title())),
                element("style", style),
                "</head>",
                element("body", body),
                "</html>",
                "",
            ]
        )

    def _title(self) -> str:
        count = self._columns.tally.count
        name = self._about.get("mission", "a sweep")
        return f"{name}: {count.succeeded:,} of {count.scenarios:,} succeeded"

    def _head(self) -> str:
        count = self._columns.tally.count
        parts = [element("h1", escape_markup(self._title()))]
        if count.interval is not None and count.success_rate is not None:
            told = (
                f"Success rate <b>{percent(count.success_rate)}</b>; 95 % confidence interval "
                f"{span(*count.interval)} (Wilson)."
            )
            if count.samples_in_words:
                told += f" <b>{escape_markup(count.samples_in_words)}</b>."
            parts.append(element("p", told, class_="rate"))
        planned = self._about.get("scenarios", 0)
        if planned > count.scenarios:
            told = f"{count.scenarios:,} of {planned:,} scenarios have been carried out so far."
            parts.append(element("p", told, class_="lacks"))
        shares = (
            ("success", count.succeeded),
            ("failure", count.failed),
            ("error", count.errors),
        )
        bar = "".join(
            element("span", "", class_=name, style=f"flex-grow:{number}") for name, number in shares
        )
        parts += [
            element("div", bar, class_="share", aria_hidden="true"),
            sections.facts(self._columns),
            element("noscript", hint("The charts need JavaScript; the tables do not.")),
        ]
        return element("header", rows(parts))

    def _place(self, figure: Figure, title: str, extra: str = "") -> str:
        """Keep a figure for the script; return where it is drawn."""
        self._figures.append(figure)
        drawn = element(
            "div",
            "",
            class_="drawn",
            data_figure=len(self._figures) - 1,
            role="img",
            aria_label=title,
            style=f"height:{figure['layout']['height']}px",
        )
        return element("div", element("h3", escape_markup(title)) + drawn + extra)

    def _success(self) -> str:
        made = factors_of(self._columns)
        if not made:
            return ""
        parts = [
            self._place(
                success_figure(one),
                f"Success by {one.name}",
                (hint(f"The {len(one.levels)} with least success.") if one.is_cut else "")
                + sections.levels_table(one.name, one.levels),
            )
            for one in made
        ]
        pairs, left_out = pairs_of(self._columns)
        parts += [
            self._place(pair_figure(one), f"Success in % by {one.first.name} and {one.second.name}")
            for one in pairs
        ]
        more = f"{left_out} more pairs of parameters tell less, and are left out."
        return (
            hint("Bands and whiskers are 95 % confidence intervals.")
            + element("div", rows(parts), class_="figures")
            + (hint(more) if left_out else "")
        )

    def _requirements(self) -> str:
        columns = self._columns
        if not columns.tally.requirements:
            return ""
        parts: list[str] = []
        constant: list[str] = []
        for name, one in columns.tally.requirements.items():
            margins = columns.margins(name)
            known = margins[np.isfinite(margins)]
            if not len(known):
                continue
            if known.min() == known.max():
                constant.append(name)
            elif len(parts) < MOST_MARGINS:
                units = " or ".join(sorted(filter(None, one.units)))
                axis = f"margin in {units}" if units else "margin"
                figure = histogram_figure(margins, columns.passed, axis, marks_zero=True)
                parts.append(self._place(figure, name))
        told = f"The same margin in every run: {', '.join(constant)}." if constant else ""
        return (
            sections.requirements_table(columns)
            + element("div", rows(parts), class_="figures")
            + hint(escape_markup(told))
        )

    def _duration(self) -> str:
        columns = self._columns
        ran = columns.ran
        if not ran.any():
            return ""
        figure = histogram_figure(
            columns.seconds[ran], columns.passed[ran], "time of the mission in s"
        )
        return element("div", self._place(figure, "How long the missions took"), class_="figures")

    def _versions(self) -> list[str]:
        found = []
        for fingerprint, count in self._columns.versions.most_common():
            told = self._store.value(f"{VERSIONS} {fingerprint}") or fingerprint
            if told:
                found.append(
                    told if len(self._columns.versions) == 1 else f"{told} ({count:,} runs)"
                )
        return found


def plotly_script() -> str:
    """Return Plotly's own script, as it comes with its Python package.

    Raises:
        BtMissionError: Where it is not installed.
    """
    try:
        script: str = _asset("plotly", "package_data/plotly.min.js")
    except (ModuleNotFoundError, FileNotFoundError) as error:
        raise BtMissionError(INSTALL) from error
    return script.replace("</script", "<\\/script")


def _section(title: str, content: str) -> str:
    return element("section", element("h2", title) + content, id=title.lower().replace(" ", "-"))


def _asset(package: str, name: str) -> Any:
    return (package_files(package) / name).read_text(encoding="utf-8")
