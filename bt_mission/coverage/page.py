"""Coverage as one HTML page, with the missions as they are written."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import astuple

from bt_mission.core.text import escape_markup
from bt_mission.coverage.table import HEAD, missing_of
from bt_mission.coverage.tally import Covered, Score, Spot, Tally

STYLE = """
:root { color-scheme: light dark; --all: #2da44e; --part: #d4a72c; --none: #cf222e; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: right; padding: .2rem .6rem; border-bottom: 1px solid #8884; }
th:first-child, td:first-child { text-align: left; }
pre { font: 13px/1.6 ui-monospace, monospace; overflow-x: auto; }
pre span { display: block; border-left: .4rem solid transparent; padding-left: .6rem; }
pre .all { border-color: var(--all); }
pre .part { border-color: var(--part); background: #d4a72c22; }
pre .none { border-color: var(--none); background: #cf222e22; }
i { opacity: .55; display: inline-block; width: 3rem; font-style: normal; user-select: none; }
b { font-weight: normal; font-style: italic; margin-left: 2rem; opacity: .8; white-space: normal;
    display: inline-block; vertical-align: top; max-width: 26rem; }
"""


def page(tally: Tally) -> str:
    """The whole page."""
    files = list(tally.in_order())
    rows = [
        _row(f'<a href="#f{n}">{escape_markup(one.label)}</a>', one.score)
        for n, one in enumerate(files)
    ]
    heads = "".join(f"<th>{escape_markup(name)}</th>" for name in HEAD[:-1])
    parts = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8"><title>Coverage of missions</title>',
        f"<style>{STYLE}</style></head><body>",
        f"<h1>Coverage of missions: {int(tally.score.percent)}%</h1>",
        f"<table><thead><tr>{heads}</tr></thead><tbody>{''.join(rows)}",
        f"{_row('in all', tally.score)}</tbody></table>",
    ]
    for number, one in enumerate(files):
        lines = "".join(_lines(one))  # a line feed between two would be a line of its own
        parts += [f'<h2 id="f{number}">{escape_markup(one.label)}</h2>', f"<pre>{lines}</pre>"]
    return "\n".join([*parts, "</body></html>", ""])


def _row(name: str, score: Score) -> str:
    counts = (*astuple(score), f"{int(score.percent)}%")
    cells = "".join(f"<td>{one}</td>" for one in counts)
    return f"<tr><td>{name}</td>{cells}</tr>"


def _lines(covered: Covered) -> Iterator[str]:
    by_line: defaultdict[int, list[Spot]] = defaultdict(list)
    for spot in covered.in_order():
        by_line[spot.line].append(spot)
    for number, line in enumerate(covered.source, 1):
        spots = by_line.get(number, [])
        said = [(spot.name, missing_of(spot)) for spot in spots]
        notes = [f"{name} {text}" if len(spots) > 1 else text for name, text in said if text]
        note = f"<b>{escape_markup('; '.join(notes))}</b>" if notes else ""
        kind = _kind(spots)
        yield f'<span class="{kind}"><i>{number}</i>{escape_markup(line)}{note}</span>'


def _kind(spots: list[Spot]) -> str:
    if not spots:
        return "text"
    if not any(spot.runs for spot in spots):
        return "none"
    return "part" if any(missing_of(spot) for spot in spots) else "all"
