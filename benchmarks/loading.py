"""The time to load and check a mission by its size: medians, and memory a node.

Run it as: python benchmarks/loading.py [--rounds N] [--nodes N]
"""

from __future__ import annotations

import gc
import statistics
import tracemalloc
from collections.abc import Iterator
from itertools import cycle

from measuring import arguments, figure, spread, table, times

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.sessions.check import examine
from bt_mission.sessions.load import load

SIZES = (1000, 3000, 10_000)

HEAD = "mission: big\ninputs: {speed: 0.2, legs: 3}\ntree:\n  sequence:\n"

PARTS = (
    (
        4,
        """\
    - sequence:
        - turn: {{angle: "-sign(speed) * uniform(60, 120)"}}
          timeout: 30
          outputs: {{angle_turned: turned_{0}}}
        - log: turned $turned_{0} deg
        - wait: uniform(1, 3)
""",
    ),
    (
        2,
        """\
    - repeat: {{count: $legs}}
      do:
        explore_forward: {{fwd_velocity: $speed, stopping_distance: 0.5}}
        timeout: 30
        cancel_when: current_distance_travelled > 2.0
        on_cancel: success
""",
    ),
    (
        4,
        """\
    - fallback:
        - check: speed > 0.1 and legs < 5
        - navigate_to_pose: {{pose: [1.5, 0.5, 90]}}
          timeout: 90
        - wait: 1
""",
    ),
    (
        3,
        """\
    - parallel:
        - camera_sweep: {{sweep_angle: 180, image_count: 8}}
          timeout: 60
        - wait: 2.0
      succeed_when: any
""",
    ),
    (3, "    - set: {{far_{0}: speed * 2}}\n    - when: far_{0} > 0.3\n      do: {{wait: 1}}\n"),
)
"""Pieces of a mission with the number of their nodes; `{0}` is another number in each."""


def mission_of(nodes: int) -> str:
    """Return a mission of about as many nodes as given, of mixed kinds."""
    text, count = [HEAD], 1
    for index, (size, part) in enumerate(cycle(PARTS)):
        if count >= nodes:
            return "".join(text)
        text.append(part.format(index))
        count += size
    raise AssertionError


def _rows(rounds: int, sizes: tuple[int, ...]) -> Iterator[list[object]]:
    for size in sizes:
        text = mission_of(size)
        loads, both = [], []
        for _ in range(rounds):
            gc.collect()
            watch = Stopwatch()
            mission = load(text)
            loads.append(watch.elapsed_s)
            watch = Stopwatch()
            assert examine(text)[1] == ()
            both.append(watch.elapsed_s)
        nodes = sum(1 for _ in mission.tree.walk())
        both_ms = figure(f"{size} nodes: load and check", times(1000, both), "ms")
        cells = [nodes, len(text), spread(times(1000, loads), "ms"), spread(both_ms, "ms")]
        us_a_node = f"{1000 * statistics.median(both_ms) / nodes:.0f}"
        yield [*cells, us_a_node, f"{_memory(text, nodes):.1f}"]


def _memory(text: str, nodes: int) -> float:
    gc.collect()
    tracemalloc.start()
    mission = load(text)
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    del mission
    return kept / nodes / 1024


def main() -> None:
    """Measure, and print a table."""
    options = arguments(__doc__, rounds=7, nodes=(SIZES[-1], "of the largest mission"))
    print("### Loading and checking\n")
    examine(mission_of(10))  # the ROS types are imported once
    head = ("nodes", "bytes", "load", "load and check", "us a node", "memory, KiB a node")
    table(head, _rows(options.rounds, tuple(size for size in SIZES if size <= options.nodes)))


if __name__ == "__main__":
    main()
