"""What a live mission costs: processor time of simulator, servers and executive, as processes.

They run in a ROS domain of their own, at the speed of the wall clock, while the robot drives and
turns to and fro. After a while, what each has used is read from `/proc/PID/stat` before and after
some seconds, so that its start is not in it: a share of one processor. Ticks of that file are
10 ms; below 1 % of 20 s is not to be told from nothing.
Run it as: python benchmarks/live.py [--seconds 20] [--rounds N]
"""

from __future__ import annotations

import argparse
import select
import tempfile
from pathlib import Path

from measuring import NOT_SOUND, figure, process_usage, spread, table

from bt_mission.core.wall_clock import Stopwatch
from bt_mission.testing.live_graph import LiveGraph, own_domain

MISSION = """\
mission: to and fro
tree:
  repeat: {count: 1000000}
  do:
    sequence:
      - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.5}
        cancel_when: current_distance_travelled > 1.0
        on_cancel: success
        timeout: 60
      - turn: {angle: 120}
        timeout: 60
"""
WORLD = "nav_arena"
SETTLE_S = 3.0
"""After the first leg has begun, before anything is measured."""
OUTPUT_SHOWN = 2000
"""Characters of the last output of a process that ended early."""


def pause(seconds: float) -> None:
    """Let the other processes run."""
    select.select([], [], [], seconds)


def measure(seconds: float, rounds: int, settle_s: float) -> dict[str, list[float]]:
    """Share of a processor that each process uses, %, in each round."""
    shares: dict[str, list[float]] = {}
    with tempfile.TemporaryDirectory() as name, own_domain() as domain_id:
        graph = LiveGraph(Path(name), domain_id)
        try:
            simulator, servers = graph.robot(WORLD)
            executive = graph.run(MISSION)
            executive.until("explore_forward")
            pause(settle_s)
            processes = {"sim": simulator, "servers": servers, "executive": executive}
            for _ in range(rounds):
                watch = Stopwatch()
                before = {
                    each: process_usage(process.pid)[0] for each, process in processes.items()
                }
                pause(seconds)
                wall_s = watch.elapsed_s
                for each, process in processes.items():
                    used_s = process_usage(process.pid)[0] - before[each]
                    shares.setdefault(each, []).append(100 * used_s / wall_s)
            ended = {
                each: ended_process
                for each, ended_process in processes.items()
                if ended_process.code is not None
            }
            if ended:
                for each, process in ended.items():
                    print(f"{each} ended before it was measured:\n{process.output[-OUTPUT_SHOWN:]}")
                raise SystemExit(NOT_SOUND)
        finally:
            graph.close()
    return shares


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=20.0, help="of each measurement")
    parser.add_argument("--settle", type=float, default=SETTLE_S, help="seconds before the first")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    shares = measure(options.seconds, options.rounds, options.settle)
    shares["all three"] = [sum(each) for each in zip(*shares.values(), strict=True)]
    for name, values in shares.items():
        figure(f"{name}, CPU at 1 x real time", values, "%")
    rows = [(name, spread(values, 1, "%")) for name, values in shares.items()]
    table(("process", "of one processor"), rows)


if __name__ == "__main__":
    main()
