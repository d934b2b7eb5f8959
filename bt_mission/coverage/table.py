"""Coverage as text: a table of files, and of each the part of the tree that was not reached."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import astuple

from bt_mission.coverage.tally import Covered, Score, Spot, Tally

HEAD = ("missions", "nodes", "reached", "outcomes", "seen", "branches", "taken", "cover", "missing")

MANY = 4
"""Outcomes that are missing at one node, of which more are not listed to people."""


def table(tally: Tally) -> Iterator[str]:
    """A line for each file, and one for all."""
    rows: list[tuple[str, ...]] = [HEAD]
    for one in tally.in_order():
        unreached = [spot.line for spot in one.in_order() if not spot.runs]
        rows.append(_row(one.label, one.score, in_ranges(unreached, one)))
    if len(rows) != 2:
        rows.append(_row("in all", tally.score, ""))
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEAD))]
    for row in rows:
        cells = [row[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(row[1:-1], widths[1:-1], strict=True)]
        yield "  ".join([*cells, row[-1]]).rstrip()


def trees(tally: Tally, *, brief: bool = False) -> Iterator[str]:
    """Of each file, the nodes of which something was not reached, below those that lead there.

    Args:
        brief: Tell of a node with many outcomes what was seen, instead of all that was not.
    """
    for one in tally.in_order():
        lines = list(_tree(one, brief=brief))
        if lines:
            yield from ("", one.label, *lines)


def _row(name: str, score: Score, missing: str) -> tuple[str, ...]:
    return (name, *map(str, astuple(score)), f"{int(score.percent)}%", missing)


def in_ranges(lines: Iterable[int], covered: Covered) -> str:
    """Line numbers as ``7, 12-15``; lines between two without a node do not part them."""
    wanted = sorted(set(lines))
    others = {spot.line for spot in covered.spots.values()} - set(wanted)
    ranges: list[list[int]] = []
    for line in wanted:
        if ranges and not any(ranges[-1][1] < other < line for other in others):
            ranges[-1][1] = line
        else:
            ranges.append([line, line])
    return ", ".join(f"{a}-{b}" if b > a else f"{a}" for a, b in ranges)


def _tree(covered: Covered, *, brief: bool) -> Iterator[str]:
    shown: dict[int, str] = {}
    spots = covered.in_order()
    above: list[int] = []
    hidden_below: int | None = None
    for number, spot in enumerate(spots):
        above = [one for one in above if _leads_to(spots[one], spot)]
        if hidden_below is not None and hidden_below in above:
            continue
        hidden_below = None if spot.runs else number
        said = missing_of(spot, brief=brief)
        if said:
            for one in above:
                shown.setdefault(one, "")
            shown[number] = said
        above.append(number)
    width = max((len(f"{'  ' * spots[one].depth}{spots[one].name}") for one in shown), default=0)
    tree = ""
    for number in sorted(shown):
        spot = spots[number]
        if spot.tree != tree:
            tree = spot.tree
            yield f"        {f'tree {tree}' if tree else 'the mission'}:"
        name = f"{'  ' * spot.depth}{spot.name}"
        yield f"{spot.line:6}  {name:{width}}  {shown[number]}".rstrip()


def _leads_to(one: Spot, other: Spot) -> bool:
    return one.depth < other.depth and one.tree == other.tree


def missing_of(spot: Spot, *, brief: bool = False) -> str:
    """What was not reached of a node, in words; empty where all was."""
    if not spot.runs:
        return "never reached"
    if brief and len(spot.missing) > MANY:
        seen = [name for name, runs in spot.outcomes.items() if runs]
        return f"only: {', '.join(seen) or 'started'} (of {len(spot.outcomes)} outcomes)"
    return f"never: {', '.join(spot.missing)}" if spot.missing else ""
