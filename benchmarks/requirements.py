"""What requirements cost: the processor time of a run with none, with twenty, and of one more.

Each round runs a mission on the stage in every way, in one process, one after another. A run
repeats exactly, so each second of its virtual time is compared with itself: the time of the
quietest round counts, since everything else that a busy machine does only adds to it.
Run it as: python benchmarks/requirements.py [MISSION ...] [--rounds N]
"""

from __future__ import annotations

import argparse
import dataclasses
import statistics
import tempfile
import time
from itertools import pairwise
from pathlib import Path

from measuring import figure

from bt_mission.language.mission import Mission
from bt_mission.language.requirements.formula import Formula, Requirement
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage

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


def seconds(mission: Mission, texts: tuple[str, ...]) -> list[float]:
    """Return the processor time of each second of virtual time."""
    requirements = tuple(
        Requirement(f"{number}", text, Formula(text).root) for number, text in enumerate(texts)
    )
    mission = dataclasses.replace(mission, requirements=requirements)
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(mission, image_folder=Path(folder), say=lambda _: None) as stage,
    ):
        marks = [time.thread_time()]
        next_ns = stage.start_ns
        while not stage.is_done:
            stage.step()
            if stage.now_ns >= next_ns:
                next_ns += 1_000_000_000
                marks.append(time.thread_time())
        marks.append(time.thread_time())
    return [after - before for before, after in pairwise(marks)]


def measure(mission_file: Path, rounds: int) -> None:
    """Measure one mission, and print what it came to."""
    mission = load(mission_file)
    runs: dict[str, list[list[float]]] = {name: [] for name in WAYS}
    seconds(mission, WAYS["twenty and clearance"])  # the first run imports and compiles
    for _ in range(rounds):
        for name, texts in WAYS.items():
            runs[name].append(seconds(mission, texts))
    quietest = {name: sum(map(min, zip(*found, strict=True))) for name, found in runs.items()}
    print(f"{mission_file}: {quietest['none']:.2f} s of processor time without requirements")
    for name in list(WAYS)[1:]:
        ratios = [
            sum(found) / sum(bare) - 1 for found, bare in zip(runs[name], runs["none"], strict=True)
        ]
        figure(f"{mission_file.stem}: {name} to without", [1 + one for one in ratios])
        print(
            f"  {name:21} {quietest[name] / quietest['none'] - 1:+7.2%}   rounds: median "
            f"{statistics.median(ratios):+.2%}, {min(ratios):+.2%} to {max(ratios):+.2%}"
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
