"""What of the tree all runs together have reached, and how often."""

from __future__ import annotations

from collections.abc import Iterator

from bt_mission.core.text import escape_markup
from bt_mission.coverage.places import REACHED, CoveragePlace
from bt_mission.coverage.record import CoverageRecord
from bt_mission.sweeps.report.columns import SweepColumns
from bt_mission.sweeps.report.markup import line
from bt_mission.sweeps.summary import percent
from bt_mission.views.html_report.markup import element, number, rows, table


def coverage_section(columns: SweepColumns, places: tuple[CoveragePlace, ...]) -> str:
    """Return how often each node was reached, and which outcomes and branches it had."""
    total = sum(count for text, count in columns.coverage.items() if text)
    if not places or not total:
        return ""
    record = CoverageRecord(places)
    for text, count in columns.coverage.items():
        if text:
            record.add(text, count)
    nodes = record.places
    seen = sum(1 for one in nodes if one.runs)
    ways = [count for one in nodes for count in _ways(one).values()]
    told = (
        f"{seen} of {len(nodes)} nodes were reached, and {sum(1 for one in ways if one)} of "
        f"{len(ways)} outcomes and branches."
    )
    never = [line_ for one in nodes for line_ in _never(one)]
    missing = ""
    if never:
        content = element("ul", rows(element("li", escape_markup(one)) for one in never))
        missing = element("details", element("summary", "what no run has reached") + content)
    return (
        element("p", told)
        + missing
        + table(
            ("node", "reached by", "outcomes and branches"),
            (_node(one, total) for one in nodes),
            "scroll coverage",
        )
    )


def _never(one: CoveragePlace) -> Iterator[str]:
    where = f"{one.name} ({_place_of(one)})"
    if not one.runs:
        yield where
    else:
        missing = [_way_told(way) for way, count in _ways(one).items() if not count]
        if missing:
            yield f"{where}: {', '.join(missing)}"


def _node(one: CoveragePlace, total: int) -> str:
    share = one.runs / total
    meter = element(
        "span",
        element("span", "", style=f"width:{number(100 * share, 1)}%"),
        class_="meter",
        aria_hidden="true",
    )
    ways = " ".join(
        element("span", f"{escape_markup(_way_told(way))} <b>{_of(count, total)}</b>", class_="way")
        for way, count in _ways(one).items()
        if count
    )
    never = [_way_told(way) for way, count in _ways(one).items() if not count and one.runs]
    if never:
        ways += element("small", escape_markup(f"never {', '.join(never)}"))
    name = element("span", escape_markup(one.name), style=f"padding-left:{min(one.depth, 8)}em")
    return line(
        (name, f"{meter}{_of(one.runs, total)}", ways),
        ("node", "reached", "ways"),
        class_=None if one.runs else "never",
    )


def _ways(one: CoveragePlace) -> dict[str, int]:
    return {mark: runs for mark, runs in one.marks.items() if mark != REACHED}


def _place_of(one: CoveragePlace) -> str:
    return one.label.removesuffix(f" {one.name}")


def _way_told(way: str) -> str:
    return way.removeprefix("outcome ")


def _of(count: int, total: int) -> str:
    return "never" if not count else "always" if count == total else percent(count / total)
