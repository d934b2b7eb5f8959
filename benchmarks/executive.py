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

PARTS = {
    "ticks": lambda rounds: executive_ticks.compare(rounds, (100, 1000, 10_000)),
    "extras": lambda rounds: executive_ticks.compare_extras(rounds, 1000),
    "goals": executive_goals.compare,
    "halts": executive_goals.compare_halts,
    "loading": loading.measure,
}


def main() -> None:
    """Measure, and print tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--only", choices=PARTS, action="append", help="may be given repeatedly")
    options = parser.parse_args()
    isolate(visible=False)
    for name in options.only or PARTS:
        PARTS[name](options.rounds)


if __name__ == "__main__":
    main()
