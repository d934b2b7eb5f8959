"""The results of a sweep for a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

from rich.console import RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from bt_mission.base.text import number
from bt_mission.commands.sweep.columns import NATURE, SweepColumns
from bt_mission.commands.sweep.repeat import Repeater, parameters_as_text
from bt_mission.commands.sweep.report.explanation import Explainer
from bt_mission.commands.sweep.report.factors import Factor, factors_of
from bt_mission.commands.sweep.summary import percent, shown_verdicts, span
from bt_mission.scenarios.cause import KINDS
from bt_mission.scenarios.concrete.row import ScenarioRow

MOST_GROUPS = 8


def tables(
    name: str, columns: SweepColumns, worst: Sequence[ScenarioRow], repeater: Repeater
) -> Iterator[RenderableType]:
    """Yield the tables of a sweep, each with its heading.

    Args:
        name: The mission's name.
        worst: The scenarios that are listed one by one.
    """
    tally = columns.tally
    yield Text(f"{name}: {tally.count}")
    yield Text(
        f"{tally.count.failed:,} failed, {tally.count.errors:,} could not run; "
        f"{tally.orphaned_goals:,} goals orphaned, {tally.collisions:,} collisions"
    )
    for factor in factors_of(columns):
        if factor.name.startswith(NATURE):
            continue  # they are too many; the page has them
        yield from _section(f"by {factor.name}", _levels(factor))
    if tally.requirements:
        yield from _section("requirements", _requirements(columns))
    if tally.failures:
        yield from _failures(columns, repeater)
    if worst:
        yield from _section("the worst", _worst(worst))


def _section(title: str, *parts: RenderableType) -> Iterator[RenderableType]:
    yield Text(f"\n{title}", style="bold")
    for part in parts:
        yield part if isinstance(part, Text) else Padding(part, (0, 0, 0, 2))


def _table(columns: Iterable[str], right: str = "") -> Table:
    """Return a table without lines; columns with a mark in `right` are right-aligned."""
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="dim")
    for place, name in enumerate(columns):
        is_right = right[place : place + 1] == ">"
        table.add_column(name, justify="right" if is_right else "left", no_wrap=is_right)
    return table


def _levels(factor: Factor) -> Table:
    table = _table((factor.name, "scenarios", "distinct", "succeeded", "share", "95 %"), " >>>> ")
    for level in factor.levels:
        table.add_row(
            Text(level.label),
            f"{level.total:,}",
            f"{level.total if level.samples is None else level.samples:,}",
            f"{level.passed:,}",
            percent(level.rate),
            span(*level.interval),
        )
    return table


def _requirements(columns: SweepColumns) -> Table:
    tallies = columns.tally.requirements
    verdicts = shown_verdicts(tallies.values())
    table = _table(
        ("", *verdicts, "holds, 95 %", "smallest margin"), f" {'>' * (len(verdicts) + 2)}"
    )
    for name, requirement in tallies.items():
        counts = [f"{requirement.verdicts[verdict]:,}" for verdict in verdicts]
        interval = "" if requirement.interval is None else span(*requirement.interval)
        least = (
            ""
            if requirement.least is None
            else f"{number(requirement.least)} {requirement.unit}".strip()
        )
        table.add_row(Text(name), *counts, interval, least)
    return table


def _failures(columns: SweepColumns, repeater: Repeater) -> Iterator[RenderableType]:
    """Yield the most frequent causes of each kind, after its heading."""
    explainer = Explainer(columns)
    for kind, several in groupby(columns.tally.failures, lambda group: group.kind):
        of_kind = list(several)
        parts = []
        for group in of_kind[:MOST_GROUPS]:
            parts.append(Text.assemble((f"  {group.count:,} times ", "bold"), group.reason))
            if explanation := explainer.explain(group.cause):
                parts.append(Text(f"    {explanation}"))
            parts.append(Text(f"    {repeater.command(group.example)}", style="dim"))
        if len(of_kind) > MOST_GROUPS:
            left = len(of_kind) - MOST_GROUPS
            parts.append(Text(f"  and {left:,} other causes: see --json or the page"))
        yield from _section(KINDS[kind], *parts)


def _worst(rows: Sequence[ScenarioRow]) -> Table:
    table = _table(("id", "scenario", "values", "outcome"), " >")
    for row in rows:
        outcome = Text("succeeded" if row.passed else row.why_failed, no_wrap=True)
        outcome.overflow = "ellipsis"
        table.add_row(row.id, str(row.number), Text(parameters_as_text(row)), outcome)
    return table
