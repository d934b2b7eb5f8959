"""The cost of virtual time on stages: with more robots, obstacles, rays and nodes; of each robot.

What is measured is the processor time of the thread; stages take turns, so that all have the same
noise. Those of `--only`:

- robots: in one world, each turning on the spot, with its own servers and executive;
- obstacles: boxes on a floor of 80 m x 80 m, one robot turning among them;
- rays: of the lidar of one robot;
- nodes: of a tree of which all run (a parallel of waits), one robot standing;
- models: the shipped robots patrol the same arena; the rate is the Waffle's cost divided by the
  robot's. Those with two lidars also run with a Waffle's in their place: the rest is what their
  drive costs. The first lidar costs as much more as the Waffle does with all of its scans than with
  a quarter of them, scaled to all; a second one as much as the Waffle does more with it.

Does the cost of a step of 50 ms grow in proportion? Of each size the least cost of all rounds
counts, since a busy machine only adds to it. A line is laid through the costs by least squares of
the relative deviations. If the largest deviation is above 15 %, the growth is not called linear.

Run it as: python benchmarks/scaling.py [--only NAME ...] [--rounds N] [--seconds S] [--most N]
"""

from __future__ import annotations

import math
import re
import statistics
import tempfile
from argparse import Namespace
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
from measuring import CpuWatch, arguments, figure, in_turns, ratios, spread, table, times

from bt_mission.base.files import find, names
from bt_mission.base.yaml.document import Document, read, read_text
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions

STEP_S = 0.05
LINEAR = 0.15
"""The largest deviation of a cost from the line."""

TURNS = "mission: turns\ntree:\n  repeat: {count: 100000}\n  do: {turn: {angle: 90}, timeout: 60}\n"
PATROL = """\
mission: patrol
tree:
  follow_waypoints:
    number_of_loops: 1000
    poses: [[-1.85, -1.76, 0], [1.85, -1.02, 90], [-1.83, 1.13, 0], [1.87, 1.87, -90]]
  timeout: 1000000
"""
FLOOR = 80.0
"""Edge of the floor, m."""

WAFFLE = "waffle"
SPARSE, SECOND = "waffle, 2.5 scans a second", "waffle, two lidars"
TWO_LIDARS = ("f1tenth", "husky")
FEWER = 4
"""The Waffle's scans a second to those of the sparse one."""


# ---- stages --------------------------------------------------------------------------------------


def one_robot(mission: str, model: Document, world: str, folder: Path) -> Stage:
    """Return a stage with a robot."""
    member = FleetRobot("", load(mission), model=model)
    return Stage(robots=[member], image_folder=folder, options=StageOptions(world=world, seed=1))


def of_robots(count: int, folder: Path) -> Stage:
    """Return a stage with a number of robots, 2 m apart."""
    mission, side = load(TURNS), math.ceil(math.sqrt(count))
    members = [
        FleetRobot(f"robot{i}", mission, x=2.0 * (i % side - side // 2), y=2.0 * (i // side))
        for i in range(count)
    ]
    options = StageOptions(world=floor(0), seed=1)
    return Stage(robots=members, image_folder=folder, say=lambda _: None, options=options)


def of_obstacles(count: int, folder: Path) -> Stage:
    """Return a stage with a number of boxes."""
    return Stage(load(TURNS), image_folder=folder, options=StageOptions(world=floor(count)))


def of_rays(count: int, folder: Path) -> Stage:
    """Return a stage whose robot has a number of rays."""
    text = find("robots", WAFFLE).read_text(encoding="utf-8")
    model = read_text(re.sub(r"rays: \d+", f"rays: {count}", text))
    return one_robot(TURNS, model, "dqn_stage4", folder)


def of_nodes(count: int, folder: Path) -> Stage:
    """Return a stage whose mission has a number of running leaves."""
    leaves = "    - wait: 100000\n" * count
    mission = load(f"mission: waits\nworld: empty_arena\ntree:\n  parallel:\n{leaves}")
    return Stage(mission, image_folder=folder)


def floor(obstacles: int) -> Document:
    """Return a floor with walls around it and boxes on it, away from the middle."""
    per_row = math.ceil(math.sqrt(obstacles + 9)) | 1
    pitch = (FLOOR - 4) / per_row
    half = per_row // 2
    places = [
        (column * pitch, row * pitch)
        for row, column in product(range(-half, half + 1), repeat=2)
        if abs(row) > 1 or abs(column) > 1
    ]
    boxes = "".join(
        f"  - {{x: {x:.3f}, y: {y:.3f}, size: [0.3, 0.3, 0.5]}}\n" for x, y in places[:obstacles]
    )
    listed = f"boxes:\n{boxes}" if obstacles else ""
    return read_text(f"name: floor\nsize: [{FLOOR}, {FLOOR}]\nspawn: {{x: 0, y: 0}}\n{listed}")


def robots() -> dict[str, Document]:
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


# ---- what they cost ------------------------------------------------------------------------------


def stepped(stage: Stage, seconds: float) -> float:
    """Run a stage for some virtual time, and return the processor time of a step, us."""
    start_ns, watch = stage.now_ns, CpuWatch()
    while stage.now_ns - start_ns < seconds * 1e9:
        stage.step()
    return watch.elapsed_s / (stage.now_ns - start_ns) * STEP_S * 1e15


def costs(stages: Iterable[Callable[[Path], Stage]], options: Namespace) -> list[list[float]]:
    """Return the cost of a step on each stage, us, round by round."""
    with ExitStack() as made:
        folder = Path(made.enter_context(tempfile.TemporaryDirectory()))
        works = [
            partial(stepped, made.enter_context(make(folder)), options.seconds) for make in stages
        ]
        for work in works:
            work()  # until goals are under way
        return in_turns(options.rounds, *works)


@dataclass(frozen=True)
class Growth:
    """What grows, and the stage of a size."""

    what: str
    sizes: tuple[int, ...]
    make: Callable[[int, Path], Stage]

    def measure(self, options: Namespace) -> None:
        """Print how the cost of a step grows."""
        sizes = [size for size in self.sizes if size <= options.most] or list(self.sizes[:3])
        measured = costs((partial(self.make, size) for size in sizes), options)
        least = [min(us) for us in measured]
        x, y = np.array(sizes, dtype=float), np.array(least)
        each, fixed = np.polyfit(x, y, 1, w=1 / y)
        deviation = float(np.max(np.abs(fixed + each * x - y) / y))
        figure(f"a {self.what} more, CPU a step", each, "us")
        figure(f"{self.what}s: a step is beside the line by", 100 * deviation, "%")
        by_size = ", ".join(f"{size}: {us:.0f}" for size, us in zip(sizes, least, strict=True))
        line = f"{fixed:.0f} + {each:.3g} a {self.what}"
        verdict = "linear" if deviation <= LINEAR else "**not linear**"
        head = ("one more", "CPU of a step, us", "line, us", "largest deviation", "")
        table(head, [(self.what, by_size, line, f"{100 * deviation:.1f} %", verdict)])


def models(options: Namespace) -> None:
    """Print what each robot and a second lidar cost."""
    known = robots()
    makes = (partial(one_robot, PATROL, model, "wide_arena") for model in known.values())
    ms_a_step = (times(1e-3, us) for us in costs(makes, options))
    a_second = {name: times(1 / STEP_S, ms) for name, ms in zip(known, ms_a_step, strict=True)}
    waffle, rows = a_second[WAFFLE], []
    for name, ms in a_second.items():
        rates = figure(f"{name}: rate of the Waffle's", ratios(waffle, ms))
        rows.append((name, spread(ms, "ms"), spread(rates)))
    second = [
        (both - first) * (FEWER - 1) / (FEWER * (first - sparse))
        for both, first, sparse in zip(a_second[SECOND], waffle, a_second[SPARSE], strict=True)
    ]
    figure("a second lidar: cost of the first one's", statistics.median(second))
    rows.append(("a second lidar, of the first one's cost", "", spread(second)))
    table(("robot", "CPU of a second", "rate of the Waffle's"), rows)


PARTS = {
    "robots": Growth("robot", (1, 2, 4, 8, 16), of_robots).measure,
    "obstacles": Growth("obstacle", (10, 30, 100, 300, 1000), of_obstacles).measure,
    "rays": Growth("ray", (90, 180, 360, 720, 1440, 2880), of_rays).measure,
    "nodes": Growth("node", (10, 30, 100, 300, 1000), of_nodes).measure,
    "models": models,
}


def main() -> None:
    """Print the tables."""
    options = arguments(
        __doc__,
        only=PARTS,
        rounds=5,
        seconds=(10.0, "virtual, of a measurement"),
        most=(10**9, "leave larger sizes out"),
    )
    for part in options.only:
        part(options)


if __name__ == "__main__":
    main()
