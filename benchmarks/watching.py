"""What it costs to watch a mission.

A mission runs on the stage as fast as it goes, alone and with `bt-mission watch` on a terminal of
its own in turns. Measured is the share of the stage's thread that publishes for tools, of all its
processor time. Both are of one process and one run, so that a busy machine does not count. The
slow-down is by how much that share makes a mission longer, less the same without a watcher. The
time of the middleware's own threads is printed beside it: they use other cores.

Run it as: python benchmarks/watching.py [--turns N] [--seconds S]
"""

from __future__ import annotations

import os
import select
import statistics
import tempfile
import time
from argparse import Namespace
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from measuring import arguments, figures
from terminals import on_terminal

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions

MISSION = """\
mission: to and fro
world: nav_arena
seed: 7
tree:
  repeat: {count: 1000000}
  do:
    sequence:
      - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.5}
        cancel_when: current_distance_travelled > 1.0
        on_cancel: success
        timeout: 30
        outputs: {closest_obstacle_angle: obstacle}
      - turn: {angle: 120}
        timeout: 30
"""
"""Some three changes of the tree a virtual second, and feedback all the time."""

DETAILS = "/bt_mission/details"
PATIENCE_S = 120.0


def drain(terminal: int | None) -> None:
    """Read what the viewer has drawn, as a terminal would."""
    while terminal is not None and select.select([terminal], [], [], 0)[0]:
        os.read(terminal, 65536)


@dataclass
class Cost:
    """Processor time of a turn, s: publishing, the stage's thread, and all other threads."""

    publishing: float = 0.0
    thread: float = 0.0
    others: float = 0.0

    @property
    def slowdown(self) -> float:
        """The relative increase of the mission's time by publishing."""
        return self.publishing / (self.thread - self.publishing)


class Meter:
    """Measures the functions after each tick: all that is published for tools."""

    def __init__(self, stage: Stage) -> None:
        self.publishing = 0.0
        listeners = stage.executive.after_tick
        listeners[:] = [partial(self._measure, listener) for listener in listeners]

    def _measure(self, listener: Callable[[], None]) -> None:
        start = time.thread_time()
        listener()
        self.publishing += time.thread_time() - start


def turn(stage: Stage, meter: Meter, seconds: float, terminal: int | None = None) -> Cost:
    """The cost of a turn."""
    start_ns = stage.now_ns
    before = (meter.publishing, time.thread_time(), time.process_time())
    while stage.now_ns - start_ns < seconds * 1e9:
        for _ in range(50):
            stage.step()
        drain(terminal)
    if terminal is not None and not stage.node.count_subscribers(DETAILS):
        raise SystemExit("the watcher has left")
    after = (meter.publishing, time.thread_time(), time.process_time())
    publishing, thread, process = (new - old for new, old in zip(after, before, strict=True))
    return Cost(publishing, thread, process - thread)


def attach(stage: Stage, terminal: int) -> None:
    """Let the mission run until the watcher draws it."""
    watch = Stopwatch()
    while not stage.node.count_subscribers(DETAILS):
        if watch.elapsed_s > PATIENCE_S:
            raise SystemExit("the watcher did not attach")
        stage.step()
        drain(terminal)
    for _ in range(400):
        stage.step()
        drain(terminal)


def measure_slowdown(options: Namespace, *words: str) -> None:
    """Print how much more processor time a watched mission takes."""
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(
            load(MISSION),
            image_folder=Path(folder),
            say=lambda _: None,
            options=StageOptions(visible=True),
        ) as stage,
    ):
        meter = Meter(stage)
        turn(stage, meter, options.seconds)  # imports, and the first frames
        alone, watched = [], []
        for _ in range(options.turns):
            alone.append(turn(stage, meter, options.seconds))
            with on_terminal("watch", *words) as terminal:
                attach(stage, terminal)
                watched.append(turn(stage, meter, options.seconds, terminal))
            while stage.node.count_subscribers(DETAILS):
                stage.step()
    pairs = zip(watched, alone, strict=True)
    slowdowns = [100 * (seen.slowdown - other.slowdown) for seen, other in pairs]
    name = " ".join(("watch", *words))
    title = f"{options.turns} turns of {options.seconds:g} s"
    figures(title, {f"{name}: slow-down": (slowdowns, "%")})

    def median_ms(times_s: Iterable[float]) -> float:
        return statistics.median(times_s) / options.seconds * 1e3

    print(
        f"a virtual second: {median_ms(run.thread for run in alone):.1f} ms, other threads "
        f"{median_ms(run.others for run in alone):.1f} ms alone and "
        f"{median_ms(run.others for run in watched):.1f} ms watched\n"
    )


def main() -> None:
    """Measure the slow-down by both forms of `watch`."""
    options = arguments(
        __doc__,
        turns=5,
        seconds=(40.0, "virtual, of one turn"),
        json=(False, "only of `watch --json`"),
    )
    if not options.json:
        measure_slowdown(options)
    measure_slowdown(options, "--json")


if __name__ == "__main__":
    main()
