"""What do other robots and further lidars cost, beside a Waffle with one lidar?

A step is 50 ms of virtual time on the stage, with servers and executive. Its figure is the
processor time of the thread; robots take turns, so that all have the same noise.

- robots: all drive the same mission; the rate is the Waffle's cost divided by the robot's.
- lidars: the first lidar costs as much more as the Waffle does with all of its scans than with a
  quarter of them, scaled to all; the second one as much as the Waffle does more with it. Both have
  360 rays at 10 Hz.

Run it as: python benchmarks/robots.py [--mission FILE] [--rounds N] [--seconds S]
"""

from __future__ import annotations

import argparse
import re
import statistics
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

from measuring import figure, in_turns, ratios, spread, table
from scaling import STEP_S, TURNS, stepped

from bt_mission.core.files import find, names
from bt_mission.core.yaml.document import Document, read_text
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions

WAFFLE = "waffle"
SPARSE, SECOND = "waffle, 2.5 scans a second", "waffle, two lidars"
FEWER = 4
"""The Waffle's scans a second to those of the sparse one."""


def models() -> dict[str, Document]:
    """Return the robots by their names in the table."""
    texts = {name: find("robots", name).read_text(encoding="utf-8") for name in names("robots")}
    waffle = texts[WAFFLE]
    [lidar] = re.findall(r"^lidar:.*?(?=^camera:)", waffle, re.DOTALL | re.MULTILINE)
    sparse = waffle.replace(lidar, re.sub(r"rate: 10.0", "rate: 2.5", lidar))
    indented = lidar.replace("\n", "\n  ").replace("lidar:", "lidars:\n  second:").rstrip()
    texts |= {SPARSE: sparse, SECOND: waffle.replace(lidar, f"{lidar}{indented}\n")}
    return {name: read_text(text, name) for name, text in texts.items()}


def measured(mission: str, rounds: int, steps: int) -> dict[str, list[float]]:
    """Return the cost of a step of each robot, us, round by round."""
    with ExitStack() as made:
        folder = Path(made.enter_context(tempfile.TemporaryDirectory()))
        works = {}
        for name, model in models().items():
            member = FleetRobot("", load(mission), model=model)
            options = StageOptions(world="empty_arena", seed=1)
            stage = made.enter_context(Stage(robots=[member], image_folder=folder, options=options))
            works[name] = stepped(stage, steps)
        for work in works.values():
            work()  # until goals are under way
        return dict(zip(works, in_turns(rounds, *works.values()), strict=True))


def rows(costs: dict[str, list[float]]) -> Iterator[Sequence[object]]:
    """Yield a row for each robot, and one for the lidars."""
    waffle = costs[WAFFLE]
    for name, times in costs.items():
        rates = ratios(waffle, times)
        figure(f"{name}: rate of the Waffle's", rates)
        yield name, spread(times, 0, "us"), spread(rates, 2)
    second = [
        (both - first) * (FEWER - 1) / (FEWER * (first - sparse))
        for both, first, sparse in zip(costs[SECOND], waffle, costs[SPARSE], strict=True)
    ]
    figure("a second lidar: cost of the first one's", statistics.median(second))
    yield "a second lidar, of the first one's cost", "", spread(second, 2)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mission", default=TURNS, help="a file; default: turns on the spot")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--seconds", type=float, default=20.0, help="virtual, of a measurement")
    options = parser.parse_args()
    costs = measured(options.mission, options.rounds, max(round(options.seconds / STEP_S), 1))
    table(("robot", "CPU of a step", "rate of the Waffle's"), rows(costs))


if __name__ == "__main__":
    main()
