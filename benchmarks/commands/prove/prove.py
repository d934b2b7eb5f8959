"""Explorations of small random missions against plain enumeration: the same ends and findings.

Run it as: python benchmarks/commands/prove/prove.py [--count 1000] [--most 10000]
    [--results prove.jsonl]

Seed N gives two missions. The first has up to 8 nodes. Its exploration is compared with all of its
runs, each from its beginning: no state is merged, and none is put back. With more than ``--most``
steps the bound on faults is lowered to 0, and beyond that the mission counts as too large. The
second has a deadline that runs while a loop turns. Its exploration with abstract loops and
deadlines must have every end and finding of the one with exact counts and times.

Each seed is one line of the results; a second run continues where the first was stopped.
"""

from __future__ import annotations

from pathlib import Path
from unittest.mock import patch

from benchmarks.measuring import CpuWatch, arguments
from campaigns.trials import Line, conclude, counted, missing, write
from tests.commands.prove.brute_force import (
    TooManyRunsError,
    Verdicts,
    enumerated,
    explored,
    looping_mission,
    small_mission,
)

EQUAL, TOO_LARGE = "equal", "too large"


def enumeration(seed: int, most: int) -> str:
    """Compare an exploration with plain enumeration; return the result."""
    mission = small_mission(seed)
    for faults in (1, 0):
        try:
            expected = enumerated(mission, faults, most=most)
        except TooManyRunsError:
            continue
        difference = _difference(expected, explored(mission, faults))
        return difference or f"{EQUAL}, {faults} faults"
    return TOO_LARGE


def abstraction(seed: int) -> str:
    """Compare abstract loops and deadlines with exact ones; return the result."""
    mission = looping_mission(seed)
    exact = explored(mission, 1)
    with patch("bt_mission.commands.prove.abstraction.MANY_ROUNDS", 1):
        abstract = explored(mission, 1)
    lost = _beyond(exact, abstract)
    if lost != Verdicts():
        return f"lost: {lost}"
    more = len(abstract.ends - exact.ends) + len(abstract.broken - exact.broken)
    return "more than exact" if more else "as exact"


def _difference(expected: Verdicts, actual: Verdicts) -> str:
    if expected == actual:
        return ""
    return f"different: missing {_beyond(expected, actual)}, more {_beyond(actual, expected)}"


def _beyond(first: Verdicts, second: Verdicts) -> Verdicts:
    """Return what the first has and the second has not."""
    return Verdicts(
        first.ends - second.ends,
        first.broken - second.broken,
        first.given_up - second.given_up,
    )


def trial(seed: int, most: int) -> Line:
    """Compare both missions of a seed."""
    results = {"enumeration": enumeration(seed, most), "abstraction": abstraction(seed)}
    findings = [text for text in results.values() if text.startswith(("different", "lost"))]
    return {"number": seed, **results, "findings": findings}


def main() -> None:
    """Compare, and print how many were equal."""
    options = arguments(__doc__, count=1000, most=10_000, results=Path("prove.jsonl"))
    watch = CpuWatch()
    todo = missing(options.results, options.count)
    lines = write((trial(seed, options.most) for seed in todo), options.results)
    kinds = ("enumeration", "abstraction")
    counts = [f"{kind}: {counted(line[kind] for line in lines)}" for kind in kinds]
    conclude(lines, *counts, f"{watch.elapsed_s:.0f} s of processor time")


if __name__ == "__main__":
    main()
