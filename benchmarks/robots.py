"""What do other robots and further lidars cost, beside a Waffle with one lidar?

Each is on a stage, with servers and executive. Its figure is the processor time of the thread for a
second of virtual time; robots take turns, so that all have the same noise.

- robots: all patrol the same arena; the rate is the Waffle's cost divided by the robot's. Those
  with two lidars also run with a Waffle's in their place: the rest is what their drive costs.
- lidars: the first lidar costs as much more as the Waffle does with all of its scans than with a
  quarter of them, scaled to all; the second one as much as the Waffle does more with it. Both have
  360 rays at 10 Hz.

Run it as: python benchmarks/robots.py [--rounds N] [--seconds S]
"""

from __future__ import annotations

import argparse
import re
import statistics
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

from measuring import CpuWatch, figure, in_turns, ratios, spread, table

from bt_mission.core.files import find, names
from bt_mission.core.yaml.document import Document, read, read_text
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions

PATROL = """\
mission: patrol
tree:
  follow_waypoints:
    number_of_loops: 1000
    poses: [[-1.85, -1.76, 0], [1.85, -1.02, 90], [-1.83, 1.13, 0], [1.87, 1.87, -90]]
  timeout: 1000000
"""
WORLD = "wide_arena"
WAFFLE = "waffle"
SPARSE, SECOND = "waffle, 2.5 scans a second", "waffle, two lidars"
TWO_LIDARS = ("f1tenth", "husky")
FEWER = 4
"""The Waffle's scans a second to those of the sparse one."""


def models() -> dict[str, Document]:
    """Return the robots by their names in the table."""
    shipped = {name: read(find("robots", name)) for name in names("robots")}
    waffle = find("robots", WAFFLE).read_text(encoding="utf-8")
    lidar = lidars_in(waffle)
    sparse = waffle.replace(lidar, re.sub(r"rate: 10.0", "rate: 2.5", lidar))
    indented = lidar.replace("\n", "\n  ").replace("lidar:", "lidars:\n  second:").rstrip()
    second = waffle.replace(lidar, f"{lidar}{indented}\n")
    others = {f"{name}, a Waffle's lidar": with_lidar(name, lidar) for name in TWO_LIDARS}
    return {**shipped, **others, SPARSE: read_text(sparse), SECOND: read_text(second)}


def lidars_in(robot: str) -> str:
    """Return what the file of a robot says about its lidars."""
    [lidars] = re.findall(r"^lidar:.*?(?=^camera:)", robot, re.DOTALL | re.MULTILINE)
    return lidars


def with_lidar(name: str, lidar: str) -> Document:
    """Return a robot with another lidar in the place of its first one, and no second one."""
    robot = find("robots", name).read_text(encoding="utf-8")
    own = lidars_in(robot)
    for axis in "xyz":
        [place] = re.findall(rf"^  {axis}: .*$", own.partition("\nlidars:")[0], re.MULTILINE)
        lidar = re.sub(rf"^  {axis}: .*$", place, lidar, flags=re.MULTILINE)
    return read_text(robot.replace(own, lidar))


def run_for(stage: Stage, seconds: float) -> Callable[[], float]:
    """Return a function that runs a stage, and returns the cost of a second of virtual time, ms."""

    def work() -> float:
        start_ns, watch = stage.now_ns, CpuWatch()
        while stage.now_ns - start_ns < seconds * 1e9:
            stage.step()
        cost_ms: float = watch.elapsed_s / ((stage.now_ns - start_ns) / 1e9) * 1e3
        return cost_ms

    return work


def measured(rounds: int, seconds: float) -> dict[str, list[float]]:
    """Return the cost of a second of each robot, ms, round by round."""
    with ExitStack() as made:
        folder = Path(made.enter_context(tempfile.TemporaryDirectory()))
        works = {}
        for name, model in models().items():
            member = FleetRobot("", load(PATROL), model=model)
            options = StageOptions(world=WORLD, seed=1)
            stage = made.enter_context(Stage(robots=[member], image_folder=folder, options=options))
            works[name] = run_for(stage, seconds)
        for work in works.values():
            work()  # until goals are under way
        return dict(zip(works, in_turns(rounds, *works.values()), strict=True))


def rows(costs: dict[str, list[float]]) -> Iterator[Sequence[object]]:
    """Yield a row for each robot, and one for the lidars."""
    waffle = costs[WAFFLE]
    for name, times in costs.items():
        rates = ratios(waffle, times)
        figure(f"{name}: rate of the Waffle's", rates)
        yield name, spread(times, 1, "ms"), spread(rates, 2)
    second = [
        (both - first) * (FEWER - 1) / (FEWER * (first - sparse))
        for both, first, sparse in zip(costs[SECOND], waffle, costs[SPARSE], strict=True)
    ]
    figure("a second lidar: cost of the first one's", statistics.median(second))
    yield "a second lidar, of the first one's cost", "", spread(second, 2)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--seconds", type=float, default=20.0, help="virtual, of a measurement")
    options = parser.parse_args()
    costs = measured(options.rounds, options.seconds)
    table(("robot", "CPU of a second", "rate of the Waffle's"), rows(costs))


if __name__ == "__main__":
    main()
