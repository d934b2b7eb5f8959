"""How fast each strategy explores a world: the figures of docs/explanation/exploration.md.

Each strategy drives in each world for three virtual minutes, once for every seed, while the mapper
runs beside it. What is known of the floor and which zones were visited is noted every second, and
kept in a file, so that a run that is there is not repeated; then table and plot are made anew.
Run it as: python benchmarks/coverage.py [--seeds N] [--runs FILE] [--only-runs | --only-report]
"""

from __future__ import annotations

import argparse
import json
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from coverage_report import write_report
from measuring import figure
from scipy import ndimage

from action_servers.core.maneuver import Grid
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import START_NS, Stage
from sim.world.loader import load_world
from sim.world.occupancy import FREE, rasterise

STRATEGIES = ("fixed", "random", "levy", "informed", "frontiers")
WORLDS = ("explore_arena", "turtlebot3_house")
DURATION_S = 180
SPEED = 0.26
"""m/s: the fastest of a Waffle, at which the frontier strategy navigates, too."""


@dataclass(frozen=True)
class Run:
    """One run, with a value after every second; the last one holds when a mission has ended.

    `floor` is the share of the world's floor that is known, 0 to 1, `zones` the number of 1 m
    squares visited.
    """

    strategy: str
    world: str
    seed: int
    status: str
    collisions: int
    driven: float
    ended_s: float
    floor: list[float]
    zones: list[int]


class Floor:
    """The floor of a world that can be reached from where the robot starts."""

    def __init__(self, world: str) -> None:
        scene = load_world(world)
        drawn = rasterise(scene)
        labels, _ = ndimage.label(drawn.cells == FREE)
        self._resolution, self._origin = drawn.resolution, drawn.origin
        row, column = self._cells(np.array([scene.spawn.x]), np.array([scene.spawn.y]))
        self._reached = labels == labels[row[0], column[0]]
        self.area = float(self._reached.sum()) * drawn.resolution**2

    def share(self, grid: Grid | None) -> float:
        """The share of it that a map knows to be free."""
        if grid is None:
            return 0.0
        rows, columns = np.nonzero(grid.cells == FREE)
        row, column = self._cells(
            grid.origin_x + (columns + 0.5) * grid.resolution,
            grid.origin_y + (rows + 0.5) * grid.resolution,
        )
        height, width = self._reached.shape
        inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
        return float(self._reached[row[inside], column[inside]].sum() / self._reached.sum())

    def _cells(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (
            np.floor((y - self._origin[1]) / self._resolution + 1e-9).astype(int),
            np.floor((x - self._origin[0]) / self._resolution + 1e-9).astype(int),
        )


def explored(strategy: str, world: str, seed: int, seconds: int = DURATION_S) -> Run:
    """Let a strategy drive, and note every second what is known."""
    given = {} if strategy == "frontiers" else {"duration": seconds, "speed": SPEED}
    mission = load(f"missions/explore_{strategy}.yaml", set=given, seed=seed, world=world)
    ground = Floor(world)
    floor: list[float] = []
    zones: list[int] = []
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(mission, image_folder=Path(folder), say=lambda _: None) as stage,
    ):
        assert stage.mapper is not None
        while not stage.is_done and len(floor) < seconds:
            stage.step()
            if stage.now_ns - START_NS >= (len(floor) + 1) * 1_000_000_000:
                floor.append(round(ground.share(stage.mapper.grid), 4))
                zones.append(stage.mapper.measure.zones_visited)
        return Run(
            strategy=strategy,
            world=world,
            seed=seed,
            status=stage.executive.status,
            collisions=stage.runs[0].collisions,
            driven=round(stage.runs[0].distance_travelled_m, 2),
            ended_s=(stage.now_ns - START_NS) / 1e9,
            floor=floor + [floor[-1]] * (seconds - len(floor)),
            zones=zones + [zones[-1]] * (seconds - len(zones)),
        )


def main() -> None:
    """Run what is missing, and write table and plot."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--worlds", nargs="+", default=WORLDS)
    parser.add_argument("--runs", type=Path, default=Path("runs/coverage.jsonl"))
    parser.add_argument("--strategies", nargs="+", default=STRATEGIES)
    parser.add_argument("--seconds", type=int, default=DURATION_S, help="virtual, of a run")
    parser.add_argument("--only-runs", action="store_true", help="write no report")
    parser.add_argument("--only-report", action="store_true", help="run nothing")
    options = parser.parse_args()
    options.runs.parent.mkdir(parents=True, exist_ok=True)
    text = options.runs.read_text(encoding="utf-8") if options.runs.exists() else ""
    runs = [Run(**json.loads(line)) for line in text.splitlines()]
    there = {(run.strategy, run.world, run.seed) for run in runs}
    wanted = [
        (strategy, world, seed)
        for seed in range(1, options.seeds + 1)
        for world in options.worlds
        for strategy in options.strategies
    ]
    for key in () if options.only_report else wanted:
        if key in there:
            continue
        run = explored(*key, options.seconds)
        runs.append(run)
        with options.runs.open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(run)) + "\n")
        print(
            f"{run.world} {run.strategy} seed {run.seed}: {run.status}, "
            f"{100 * run.floor[-1]:.1f} % of the floor, {run.zones[-1]} zones, "
            f"{run.driven} m, {run.collisions} collisions",
            flush=True,
        )
    for strategy in options.strategies:
        shares = [100 * run.floor[-1] for run in runs if run.strategy == strategy]
        if shares:
            figure(f"{strategy}: floor that is known after three minutes", shares, "%")
    if not options.only_runs:
        areas = {world: Floor(world).area for world in options.worlds}
        write_report([run for run in runs if (run.strategy, run.world, run.seed) in wanted], areas)


if __name__ == "__main__":
    main()
