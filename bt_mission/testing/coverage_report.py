"""Coverage as text and as HTML: a table of files, and the nodes that are not reached."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import astuple

from bt_mission.scenarios.coverage.places import CoveragePlace
from bt_mission.scenarios.coverage.record import CoverageTally, CoveredFile
from bt_mission.views.html.pages import render

HEAD = ("missions", "nodes", "reached", "outcomes", "seen", "branches", "taken", "cover", "missing")

MANY = 4
"""The terminal does not list more missing outcomes of a node than this."""


def rows(tally: CoverageTally) -> list[tuple[str, ...]]:
    """Return the cells of the table: a row for each file, and a row of totals for several files."""
    table = [
        (
            covered.label,
            *map(str, astuple(covered.score)),
            f"{int(covered.score.percent)}%",
            in_ranges([place.line for place in covered.in_order() if not place.runs], covered),
        )
        for covered in tally.in_order()
    ]
    if len(table) != 1:
        score = tally.score
        table.append(("in all", *map(str, astuple(score)), f"{int(score.percent)}%", ""))
    return table


def in_ranges(lines: Iterable[int], covered: CoveredFile) -> str:
    """Return line numbers as ``7, 12-15``.

    Lines without a node between two numbers do not split a range.
    """
    wanted = sorted(set(lines))
    others = {place.line for place in covered.places.values()} - set(wanted)
    ranges: list[list[int]] = []
    for line in wanted:
        if ranges and not any(ranges[-1][1] < other < line for other in others):
            ranges[-1][1] = line
        else:
            ranges.append([line, line])
    return ", ".join(f"{a}-{b}" if b > a else f"{a}" for a, b in ranges)


def missing_of(place: CoveragePlace, *, brief: bool = False) -> str:
    """Return the marks of a node that were not reached, as text; empty if all were.

    Args:
        brief: For a node with many missing outcomes, name the outcomes that were reached instead.
    """
    if not place.runs:
        return "never reached"
    missing = place.missing
    if brief and len(missing) > MANY:
        seen = [name for name, runs in place.outcomes.items() if runs]
        return f"only: {', '.join(seen) or 'started'} (of {len(place.outcomes)} outcomes)"
    return f"never: {', '.join(missing)}" if missing else ""


# ---- text -------------------------------------------------------------------------------------


def as_text(tally: CoverageTally, *, brief: bool = False) -> Iterator[str]:
    """Yield the lines of the table, and for each file the nodes with a mark that is missing.

    Args:
        brief: See `missing_of`.
    """
    table = [HEAD, *rows(tally)]
    widths = [max(len(row[column]) for row in table) for column in range(len(HEAD))]
    for row in table:
        cells = [row[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(row[1:-1], widths[1:-1], strict=True)]
        yield "  ".join([*cells, row[-1]]).rstrip()
    for covered in tally.in_order():
        if lines := list(_tree(covered, brief=brief)):
            yield from ("", covered.label, *lines)


def _tree(covered: CoveredFile, *, brief: bool) -> Iterator[str]:
    """Yield the nodes of which something is missing, below those that lead there."""
    shown: dict[int, str] = {}
    places = covered.in_order()
    above: list[int] = []
    hidden_below: int | None = None
    for number, place in enumerate(places):
        above = [
            ancestor
            for ancestor in above
            if places[ancestor].depth < place.depth and places[ancestor].tree == place.tree
        ]
        if hidden_below is not None and hidden_below in above:
            continue
        hidden_below = None if place.runs else number
        if missing := missing_of(place, brief=brief):
            for ancestor in above:
                shown.setdefault(ancestor, "")
            shown[number] = missing
        above.append(number)
    width = max(
        (len(f"{'  ' * places[index].depth}{places[index].name}") for index in shown), default=0
    )
    tree = ""
    for number in sorted(shown):
        place = places[number]
        if place.tree != tree:
            tree = place.tree
            yield f"        {f'tree {tree}' if tree else 'the mission'}:"
        name = f"{'  ' * place.depth}{place.name}"
        yield f"{place.line:6}  {name:{width}}  {shown[number]}".rstrip()


# ---- HTML -------------------------------------------------------------------------------------


def as_html(tally: CoverageTally) -> str:
    """Return the page: the table, and each file with what is missing beside its lines."""
    files = [(covered.label, list(_lines(covered))) for covered in tally.in_order()]
    percent = int(tally.score.percent)
    return render(
        "testing/coverage_report.html",
        percent=percent,
        head=HEAD[:-1],
        rows=rows(tally),
        files=files,
    )


def _lines(covered: CoveredFile) -> Iterator[tuple[str, str, str]]:
    by_line: defaultdict[int, list[CoveragePlace]] = defaultdict(list)
    for place in covered.in_order():
        by_line[place.line].append(place)
    for number, line in enumerate(covered.source, 1):
        places = by_line[number]
        missing = [(place.name, missing_of(place)) for place in places]
        notes = [f"{name} {text}" if len(places) > 1 else text for name, text in missing if text]
        kind = "part" if notes else "all"
        if not any(place.runs for place in places):
            kind = "none" if places else "text"
        yield kind, line, "; ".join(notes)
