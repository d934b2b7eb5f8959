"""What a live mission costs: processor time of simulator, servers and executive, as processes.

They run in a ROS domain of their own, at the speed of the wall clock, while the robot drives and
turns to and fro. After a while, what each has used is read from `/proc/PID/stat` before and after
some seconds, so that its start is not in it: a share of one processor. Ticks of that file are
10 ms; below 1 % of 20 s is not to be told from nothing.
Run it as: python benchmarks/live.py [--seconds 20] [--rounds N]
"""

from __future__ import annotations

import select
import tempfile
from pathlib import Path

from measuring import NOT_SOUND, arguments, figures, process_usage

from bt_mission.base.wall_clock import Stopwatch
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


def measure(seconds: float, rounds: int, settle_s: float) -> dict[str, list[float]]:
    """Share of a processor that each process uses, %, in each round."""
    shares: dict[str, list[float]] = {}
    with tempfile.TemporaryDirectory() as name, own_domain() as domain_id:
        graph = LiveGraph(Path(name), domain_id)
        try:
            simulator, servers = graph.robot(WORLD)
            executive = graph.run(MISSION)
            executive.until("explore_forward")
            select.select([], [], [], settle_s)
            processes = {"sim": simulator, "servers": servers, "executive": executive}
            for _ in range(rounds):
                watch = Stopwatch()
                before = {
                    each: process_usage(process.pid)[0] for each, process in processes.items()
                }
                select.select([], [], [], seconds)
                wall_s = watch.elapsed_s
                for each, process in processes.items():
                    used_s = process_usage(process.pid)[0] - before[each]
                    shares.setdefault(each, []).append(100 * used_s / wall_s)
            for each, process in processes.items():
                if process.code is not None:
                    print(f"{each} ended before it was measured:\n{process.output[-OUTPUT_SHOWN:]}")
                    raise SystemExit(NOT_SOUND)
        finally:
            graph.close()
    return shares


def main() -> None:
    """Print the table."""
    options = arguments(
        __doc__,
        seconds=(20.0, "of each measurement"),
        settle=(SETTLE_S, "seconds before the first"),
        rounds=3,
    )
    shares = measure(options.seconds, options.rounds, options.settle)
    shares["all three"] = [sum(each) for each in zip(*shares.values(), strict=True)]
    named = {f"{name}, CPU at 1 x real time": (values, "%") for name, values in shares.items()}
    figures("of one processor", named)


if __name__ == "__main__":
    main()
