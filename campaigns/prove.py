"""Explorations of small random missions against plain enumeration: the same ends and findings.

Run it as: python campaigns/prove.py [--count 1000] [--first 0] [--results prove.jsonl]

Seed N gives two missions. The first has up to 8 nodes. Its exploration is compared with all of its
runs, each from its beginning: no state is merged, and none is put back. With more than ``--most``
steps the bound on faults is lowered to 0, and beyond that the mission counts as too large. The
second has a deadline that runs while a loop turns. Its exploration with abstract loops and
deadlines must have every end and finding of the one with exact counts and times.

Each seed is one line of the results; a second run continues where the first was stopped.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from pathlib import Path
from unittest.mock import patch

from benchmarks.measuring import CpuWatch, figure
from tests.support.brute_force import (
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
    with patch("bt_mission.proving.abstraction.MANY_ROUNDS", 1):
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


def main() -> None:
    """Compare, and print how many were equal."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--most", type=int, default=10_000)
    parser.add_argument("--results", type=Path, default=Path("prove.jsonl"))
    options = parser.parse_args()
    lines = options.results.read_text().splitlines() if options.results.exists() else []
    results = {line["seed"]: line for line in map(json.loads, lines)}
    watch = CpuWatch()
    with options.results.open("a") as file:
        for seed in range(options.first, options.first + options.count):
            if seed not in results:
                line = {
                    "seed": seed,
                    "enumeration": enumeration(seed, options.most),
                    "abstraction": abstraction(seed),
                }
                results[seed] = line
                print(json.dumps(line), file=file, flush=True)
    for kind in ("enumeration", "abstraction"):
        counts = Counter(line[kind] for line in results.values())
        print(f"{kind}: {', '.join(f'{count:,} {what}' for what, count in counts.most_common())}")
    print(f"{watch.elapsed_s:.0f} s of processor time")
    figure("differences", sum(_is_wrong(line) for line in results.values()))


def _is_wrong(line: dict[str, str]) -> bool:
    return line["enumeration"].startswith("different") or line["abstraction"].startswith("lost")


if __name__ == "__main__":
    main()
