"""What requirements cost: the processor time of a run with none, with twenty, and of one more.

Each round runs a mission on the stage in every way, in one process, one after another; the second
by second quietest of all rounds counts, as in recording.py.
Run it as: python benchmarks/requirements.py [MISSION ...] [--rounds N]
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from measuring import figure, ratios, spread, table
from recording import Run, quietest, run

from bt_mission.language.requirements.formula import Formula, Requirement
from bt_mission.sessions.load import load

MISSIONS = ("missions/explore.yaml", "missions/patrol.yaml")
SOME = (
    "never collisions > 0",
    "always speed < 0.3",
    'whenever speed > 0.1: previously running("0")',
    "eventually within 600 s: distance > 1",
    'whenever age("scan") > 0.5: speed < 0.01 within 0.6 s',
)
WAYS = {
    "none": (),
    "twenty": SOME * 4,
    "clearance alone": ("always clearance > 0.01",),
    "twenty and clearance": (*SOME * 4, "always clearance > 0.01"),
}


def measure(mission_file: Path, rounds: int) -> None:
    """Measure one mission, and print the ratios."""
    mission = load(mission_file)
    missions = {name: replace(mission, requirements=_parsed(texts)) for name, texts in WAYS.items()}
    runs: dict[str, list[Run]] = {name: [] for name in WAYS}
    run(missions["twenty and clearance"])  # the first run imports and compiles
    for _ in range(rounds):
        for name, watched in runs.items():
            watched.append(run(missions[name]))
    bare = runs.pop("none")
    rows = []
    for name, watched in runs.items():
        totals = [[sum(timed.seconds) for timed in some] for some in (watched, bare)]
        figure(f"{mission_file.stem}: {name} to without", ratios(*totals))
        rows.append((name, f"{quietest(watched) / quietest(bare):.4f}", spread(ratios(*totals), 4)))
    table((f"{mission_file}: {quietest(bare):.2f} s without", "quietest", "rounds"), rows)


def _parsed(texts: tuple[str, ...]) -> tuple[Requirement, ...]:
    return tuple(
        Requirement(f"{number}", text, Formula(text).root) for number, text in enumerate(texts)
    )


def main() -> None:
    """Measure the missions of the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("missions", nargs="*", default=MISSIONS, type=Path)
    parser.add_argument("--rounds", default=5, type=int)
    options = parser.parse_args()
    for mission_file in options.missions:
        measure(Path(mission_file), options.rounds)


if __name__ == "__main__":
    main()
