"""What a camera image costs, and how many are drawn that nobody takes.

The image is that of the robot's own camera, 320 x 240, in the world of `explore.yaml`, drawn by
software where there is no graphics card. Then the mission runs: images drawn are counted beside
the pictures that its camera sweep stores; without a sweep there must be none.
Run it as: python benchmarks/image.py [--rounds N]
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from measuring import CpuWatch, figure, in_turns, spread, table

from bt_mission.core.robot.model import load_robot
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from sim.sensors.camera import Camera
from sim.simulation import Simulation
from sim.world.loader import load_world

IMAGES = 100
"""Of one measurement, unless others are asked for."""
SWEEP, NO_SWEEP = Path("missions/explore.yaml"), Path("benchmarks/explore_no_camera.yaml")


def drawing(rounds: int, images: int) -> None:
    """Print what it takes to draw an image, on the wall and of the processor."""
    robot = load_robot("waffle")
    simulation = Simulation(load_world("dqn_stage4"), robot, seed=1)
    spec = robot.camera
    camera = Camera(simulation.model, spec)
    pixels = np.empty((spec.height, spec.width, 3), dtype=np.uint8)
    walls: list[float] = []

    def work() -> float:
        cpu, wall = CpuWatch(), Stopwatch()
        for _ in range(images):
            camera.draw(simulation.data, pixels)
        walls.append(1000 * wall.elapsed_s / images)
        return 1000 * cpu.elapsed_s / images

    work()  # the first one compiles
    walls.clear()
    (cpu_ms,) = in_turns(rounds, work)
    camera.close()
    figure("an image 320x240", walls, "ms")
    figure("an image 320x240, CPU of the thread", cpu_ms, "ms")
    rows = [("wall", spread(walls, 2, "ms")), ("CPU of the thread", spread(cpu_ms, 2, "ms"))]
    table((f"an image {spec.width}x{spec.height}", "drawn"), rows)


@contextmanager
def counted() -> Iterator[list[int]]:
    """Count the images that any camera draws, while this is open."""
    count = [0]
    draw = Camera.draw

    def counting(camera: Camera, *arguments: Any) -> None:
        count[0] += 1
        draw(camera, *arguments)

    with mock.patch.object(Camera, "draw", counting):
        yield count


def drawn(file: Path) -> tuple[int, int]:
    """Run a mission; gives how many images were drawn, and how many pictures stored."""
    with (
        tempfile.TemporaryDirectory() as folder,
        counted() as count,
        Stage(load(file), image_folder=Path(folder), say=lambda _: None) as stage,
    ):
        while not stage.is_done:
            stage.step()
        stored = sum(1 for one in Path(folder).rglob("*") if one.suffix in (".png", ".jpg"))
    return count[0], stored


def taking() -> None:
    """Print how many images were drawn for those that were taken."""
    images, stored = drawn(SWEEP)
    needless, _ = drawn(NO_SWEEP)
    figure("images drawn for each that is stored", images / max(stored, 1))
    figure("images drawn without a camera sweep", needless)
    rows = [
        (SWEEP.name, images, stored),
        (NO_SWEEP.name, needless, 0),
    ]
    table(("mission", "images drawn", "pictures stored"), rows)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--images", type=int, default=IMAGES, help="of one measurement")
    options = parser.parse_args()
    drawing(options.rounds, options.images)
    taking()


if __name__ == "__main__":
    main()
