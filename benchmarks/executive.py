"""What the executive costs: ticks, goals, halts and status publishing; and loading.

Everything is set against what the same work costs without us, in one process, round by round.
Run it as: python benchmarks/executive.py [--rounds N] [--only ticks|extras|goals|halts|loading]
"""

from __future__ import annotations

import argparse

import executive_goals
import executive_ticks
import loading

from bt_mission.core.dds.discovery import isolate

MOST = 10_000
"""Nodes of the largest tree."""


def up_to(most: int, *sizes: int) -> tuple[int, ...]:
    """Those sizes that are not too large; the least of them where all are."""
    return tuple(one for one in sizes if one <= most) or (min(sizes),)


PARTS = {
    "ticks": lambda rounds, most: executive_ticks.compare(rounds, up_to(most, 100, 1000, 10_000)),
    "extras": lambda rounds, most: executive_ticks.compare_extras(rounds, min(most, 1000)),
    "goals": lambda rounds, _: executive_goals.compare(rounds),
    "halts": lambda rounds, _: executive_goals.compare_halts(rounds),
    "loading": lambda rounds, most: loading.measure(rounds, up_to(most, *loading.SIZES)),
}


def main() -> None:
    """Measure, and print tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--only", choices=PARTS, action="append", help="may be given repeatedly")
    parser.add_argument("--nodes", type=int, default=MOST, help="of the largest tree")
    options = parser.parse_args()
    isolate(visible=False)
    for name in options.only or PARTS:
        PARTS[name](options.rounds, options.nodes)


if __name__ == "__main__":
    main()
