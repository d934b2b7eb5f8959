"""What of the tree all runs together have reached, and how often."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from bt_mission.core.text import escape_markup
from bt_mission.sweeps.report.columns import SweepColumns
from bt_mission.sweeps.report.markup import line
from bt_mission.sweeps.summary import percent
from bt_mission.views.html_report.markup import element, number, rows, table

REACHED = ": reached"
_OF_MISSION = re.compile(r"(?P<place>\d+(?:\.\d+)*) (?P<name>.*)", re.DOTALL)
_OF_TREE = re.compile(r"(?P<place>.*?:\d+(?:\.\d+)*) (?P<name>.*)", re.DOTALL)


@dataclass(frozen=True)
class ReachedNode:
    """A node, with the number of runs that have reached it, its outcomes and its branches.

    Attributes:
        place: Where it stands in its tree, such as ``0.1`` or ``half:0.1``.
        ways: Outcomes and branches with the runs that have had them.
    """

    place: str
    name: str
    runs: int
    ways: dict[str, int] = field(default_factory=dict)

    @property
    def depth(self) -> int:
        """How many nodes of its tree are above it."""
        return self.place.rpartition(":")[2].count(".")


def reached_nodes(places: tuple[str, ...], bitmaps: Mapping[str, int]) -> list[ReachedNode]:
    """Add the bitmaps of all runs up.

    Args:
        places: As `coverage_places` names them.
        bitmaps: How often each came out, as `CoverageRecord` writes them.
    """
    runs = [0] * len(places)
    for text, count in bitmaps.items():
        bits = int(text, 16) if text else 0
        for bit in range(len(places)):
            if bits >> bit & 1:
                runs[bit] += count
    found: list[ReachedNode] = []
    for name, count in zip(places, runs, strict=True):
        if name.endswith(REACHED):
            node = name.removesuffix(REACHED)
            parts = _OF_MISSION.fullmatch(node) or _OF_TREE.fullmatch(node)
            place, called = (parts["place"], parts["name"]) if parts else ("", node)
            found.append(ReachedNode(place, called, count))
        elif found:
            one = found[-1]
            found[-1].ways[name.removeprefix(f"{one.place} {one.name}: ")] = count
    return found


def coverage_section(columns: SweepColumns, places: tuple[str, ...]) -> str:
    """Return how often each node was reached, and which outcomes and branches it had."""
    total = sum(count for text, count in columns.coverage.items() if text)
    if not places or not total:
        return ""
    nodes = reached_nodes(places, columns.coverage)
    seen = sum(1 for one in nodes if one.runs)
    ways = [count for one in nodes for count in one.ways.values()]
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


def _never(one: ReachedNode) -> Iterator[str]:
    where = f"{one.name} ({one.place})"
    if not one.runs:
        yield where
    else:
        missing = [_way_told(way) for way, count in one.ways.items() if not count]
        if missing:
            yield f"{where}: {', '.join(missing)}"


def _node(one: ReachedNode, total: int) -> str:
    share = one.runs / total
    meter = element(
        "span",
        element("span", "", style=f"width:{number(100 * share, 1)}%"),
        class_="meter",
        aria_hidden="true",
    )
    ways = " ".join(
        element("span", f"{escape_markup(_way_told(way))} <b>{_of(count, total)}</b>", class_="way")
        for way, count in one.ways.items()
        if count
    )
    never = [_way_told(way) for way, count in one.ways.items() if not count and one.runs]
    if never:
        ways += element("small", escape_markup(f"never {', '.join(never)}"))
    name = element("span", escape_markup(one.name), style=f"padding-left:{min(one.depth, 8)}em")
    return line(
        (name, f"{meter}{_of(one.runs, total)}", ways),
        ("node", "reached", "ways"),
        class_=None if one.runs else "never",
    )


def _way_told(way: str) -> str:
    return way.removeprefix("outcome ")


def _of(count: int, total: int) -> str:
    return "never" if not count else "always" if count == total else percent(count / total)
