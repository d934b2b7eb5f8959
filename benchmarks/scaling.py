"""Does the cost of a step grow in proportion: with robots, obstacles, rays and nodes?

A step is 50 ms of virtual time, on the stage. What is measured is the processor time of the thread;
sizes take turns, and the least of all rounds counts, since a busy machine only adds to it. A line
is laid through the costs by least squares of the relative deviations; the residual told is the
largest of them. Above 15 % the growth is not called linear.

- robots: in one world, each turning on the spot, with its own servers and executive;
- obstacles: boxes on a floor of 80 m x 80 m, one robot turning among them;
- rays: of the lidar of one robot;
- nodes: of a tree of which all run (a parallel of waits), one robot standing.

Run it as: python benchmarks/scaling.py [--only robots|obstacles|rays|nodes] [--rounds N]
"""

from __future__ import annotations

import argparse
import math
import re
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from measuring import CpuWatch, figure, in_turns, table

from bt_mission.core.files import find
from bt_mission.core.yaml.document import Document, read_text
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions

STEP_S = 0.05
LINEAR = 0.15
"""The largest deviation of a cost from the line."""

TURNS = "mission: turns\ntree:\n  repeat: {count: 100000}\n  do: {turn: {angle: 90}, timeout: 60}\n"
FLOOR = 80.0
"""Edge of the floor, m."""


@dataclass(frozen=True)
class Line:
    """A cost of `fixed` and of `each` for every one, us.

    Args:
        deviation: The largest distance of a cost from the line, as a share of that cost.
    """

    fixed: float
    each: float
    deviation: float

    @classmethod
    def through(cls, sizes: Sequence[int], costs: Sequence[float]) -> Line:
        """Return the line with the least squares of relative deviations."""
        x, y = np.array(sizes, dtype=float), np.array(costs)
        each, fixed = np.polyfit(x, y, 1, w=1 / y)
        deviation = np.max(np.abs(fixed + each * x - y) / y)
        return cls(float(fixed), float(each), float(deviation))

    @property
    def verdict(self) -> str:
        """Whether the costs are on it, as text."""
        return "linear" if self.deviation <= LINEAR else "**not linear**"


def world(obstacles: int) -> Document:
    """A floor with walls around it and boxes on it, away from the middle."""
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


def robot_with(rays: int) -> Document:
    """Return the Waffle with a number of rays."""
    text = find("robots", "waffle").read_text(encoding="utf-8")
    return read_text(re.sub(r"rays: \d+", f"rays: {rays}", text))


def of_robots(count: int, folder: Path) -> Stage:
    """Return a stage with a number of robots, 2 m apart."""
    mission, side = load(TURNS), math.ceil(math.sqrt(count))
    members = [
        FleetRobot(f"robot{i}", mission, x=2.0 * (i % side - side // 2), y=2.0 * (i // side))
        for i in range(count)
    ]
    options = StageOptions(world=world(0), seed=1)
    return Stage(robots=members, image_folder=folder, say=lambda _: None, options=options)


def of_obstacles(count: int, folder: Path) -> Stage:
    """Return a stage with a number of boxes."""
    return Stage(load(TURNS), image_folder=folder, options=StageOptions(world=world(count)))


def of_rays(count: int, folder: Path) -> Stage:
    """Return a stage whose robot has a number of rays."""
    member = FleetRobot("", load(TURNS), model=robot_with(count))
    options = StageOptions(world="dqn_stage4")
    return Stage(robots=[member], image_folder=folder, options=options)


def of_nodes(count: int, folder: Path) -> Stage:
    """Return a stage whose mission has a number of running leaves."""
    leaves = "    - wait: 100000\n" * count
    mission = load(f"mission: waits\nworld: empty_arena\ntree:\n  parallel:\n{leaves}")
    return Stage(mission, image_folder=folder)


@dataclass(frozen=True)
class Sweep:
    """What grows, and the stage of a size."""

    what: str
    sizes: tuple[int, ...]
    make: Callable[[int, Path], Stage]


SWEEPS = {
    "robots": Sweep("robot", (1, 2, 4, 8, 16), of_robots),
    "obstacles": Sweep("obstacle", (10, 30, 100, 300, 1000), of_obstacles),
    "rays": Sweep("ray", (90, 180, 360, 720, 1440, 2880), of_rays),
    "nodes": Sweep("node", (10, 30, 100, 300, 1000), of_nodes),
}


def stepped(stage: Stage, steps: int) -> Callable[[], float]:
    """Return a function that steps a stage, and returns the processor time of a step, us."""

    def work() -> float:
        watch = CpuWatch()
        for _ in range(steps):
            stage.step()
        return watch.elapsed_s / steps * 1e6

    return work


def costs(sweep: Sweep, sizes: Sequence[int], rounds: int, steps: int) -> list[list[float]]:
    """Return the cost of a step for each size, us, round by round."""
    with ExitStack() as made:
        folder = Path(made.enter_context(tempfile.TemporaryDirectory()))
        stages = [made.enter_context(sweep.make(size, folder)) for size in sizes]
        works = [stepped(stage, steps) for stage in stages]
        for work in works:
            work()  # until goals are under way
        return in_turns(rounds, *works)


def measure(name: str, rounds: int, steps: int, most: int) -> Iterator[tuple[object, ...]]:
    """Yield the row of one sweep."""
    sweep = SWEEPS[name]
    sizes = [size for size in sweep.sizes if size <= most] or list(sweep.sizes[:3])
    measured = costs(sweep, sizes, rounds, steps)
    line = Line.through(sizes, [min(times) for times in measured])
    figure(f"a {sweep.what} more, CPU a step", line.each, "us")
    figure(f"{name}: a step is beside the line by", 100 * line.deviation, "%")
    by_size = ", ".join(f"{size}: {min(us):.0f}" for size, us in zip(sizes, measured, strict=True))
    of_line = f"{line.fixed:.0f} + {line.each:.3g} a {sweep.what}"
    yield sweep.what, by_size, of_line, f"{100 * line.deviation:.1f} %", line.verdict


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=SWEEPS, action="append", help="may be given repeatedly")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=10.0, help="virtual, of a measurement")
    parser.add_argument("--most", type=int, default=10**9, help="leave larger sizes out")
    options = parser.parse_args()
    steps = max(round(options.seconds / STEP_S), 1)
    head = ("one more", "CPU of a step, us", "line, us", "largest deviation", "")
    rows = (
        row
        for name in options.only or SWEEPS
        for row in measure(name, options.rounds, steps, options.most)
    )
    table(head, rows)


if __name__ == "__main__":
    main()
