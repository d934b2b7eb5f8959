"""What it costs to watch a mission, and how fast the view is on a large tree.

Slow-down: a mission runs on the stage as fast as it goes, alone and with `bt-mission watch` on a
terminal of its own in turns. Measured is the share of the stage's thread that publishes for tools,
of all its processor time. Both are of one process and one run, so that a busy machine does not
count. The slow-down is by how much that share makes a mission longer, less the same without a
watcher. The time of the middleware's own threads is printed beside it: they use other cores.

Large tree: the full-screen view, driven by Textual's pilot, is given a tree of ten thousand nodes.
The first picture is the time from the serialised messages (the tree, all statuses) to the drawn
screen; a change is the time from the change of one node to the drawn screen.

Run it as: python benchmarks/watching.py [--turns N] [--nodes N] [--only slowdown|picture]
"""

from __future__ import annotations

import asyncio
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

from bt_mission_interfaces.msg import NodeStatus, Tree, TreeNode
from bt_mission_interfaces.srv import GetStatuses
from measuring import arguments, figure, figures, times
from rclpy.serialization import deserialize_message, serialize_message
from terminals import on_terminal

from bt_mission.core.memory import settle_memory, spare_collections
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.events import reader
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions
from bt_mission.views.terminal.marks import SIGNS
from bt_mission.views.tui.app import WatchApp
from tests.support.watched import ScriptedExecutive, ScriptedGraph, tree

VIRTUAL_S = 40.0
"""Of one turn."""

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
CHILDREN = 10
PICTURES = 5


# ---- slow-down -------------------------------------------------------------------------------


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


def turn(stage: Stage, meter: Meter, terminal: int | None) -> Cost:
    """The cost of a turn."""
    start_ns = stage.now_ns
    before = (meter.publishing, time.thread_time(), time.process_time())
    while stage.now_ns - start_ns < VIRTUAL_S * 1e9:
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
        if watch.elapsed_s > 60:
            raise SystemExit("the watcher did not attach within a minute")
        stage.step()
        drain(terminal)
    for _ in range(400):
        stage.step()
        drain(terminal)


def measure_slowdown(turns: int, *options: str) -> None:
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
        turn(stage, meter, None)  # imports, and the first frames
        alone, watched = [], []
        for _ in range(turns):
            alone.append(turn(stage, meter, None))
            with on_terminal("watch", *options) as terminal:
                attach(stage, terminal)
                watched.append(turn(stage, meter, terminal))
            while stage.node.count_subscribers(DETAILS):
                stage.step()
    name = " ".join(("watch", *options))
    pairs = zip(watched, alone, strict=True)
    slowdowns = [100 * (seen.slowdown - other.slowdown) for seen, other in pairs]
    figures(f"{turns} turns of {VIRTUAL_S:g} s", {f"{name}: slow-down": (slowdowns, "%")})
    print(
        f"a virtual second: {median_ms(run.thread for run in alone):.1f} ms, other threads "
        f"{median_ms(run.others for run in alone):.1f} ms alone and "
        f"{median_ms(run.others for run in watched):.1f} ms watched\n"
    )


def median_ms(times_s: Iterable[float]) -> float:
    """The median of turns, ms a virtual second."""
    return statistics.median(times_s) / VIRTUAL_S * 1e3


def slowdown(options: Namespace) -> None:
    """Measure the slow-down by both forms of `watch`."""
    measure_slowdown(options.turns)
    measure_slowdown(options.turns, "--json")


# ---- a large tree ----------------------------------------------------------------------------


def outline(count: int) -> str:
    """Return the outline of a tree of some nodes."""
    lines = ["large"]
    while len(lines) < count:
        is_part = (len(lines) - 1) % (CHILDREN + 1) == 0
        lines.append(f"  part {len(lines)}" if is_part else f"    leaf {len(lines)}")
    return "\n".join(lines)


def wire(text: str) -> tuple[bytes, bytes]:
    """Return a tree, and the response with all its statuses, as sent over the network."""
    started = tree(text)
    nodes = [
        TreeNode(name=node.name, kind=node.kind, path=node.path, parent=node.parent)
        for node in started.nodes
    ]
    message = Tree(run=started.run, mission=started.mission, nodes=nodes)
    message.stamp.sec = 1
    statuses = [NodeStatus(node=index) for index in range(len(nodes))]
    answer = GetStatuses.Response(run=started.run, statuses=statuses)
    return serialize_message(message), serialize_message(answer)


def drawn(app: WatchApp) -> None:
    """Have the view take what there is, and draw it."""
    app.look()
    app.screen._compositor.render_strips()  # noqa: SLF001 - what the pilot's driver does not do


async def draw(nodes: int, changes: int) -> tuple[float, list[float]]:
    """Seconds to the first picture, and of each change."""
    executive = ScriptedExecutive(outline(nodes))
    sent_tree, sent_statuses = wire(executive.outline)
    app = WatchApp(ScriptedGraph(executive), SIGNS)
    async with app.run_test(size=(140, 45)) as pilot:
        await pilot.pause()
        executive.begin()
        watch = Stopwatch()
        reader.tree(deserialize_message(sent_tree, Tree))
        reader.statuses(deserialize_message(sent_statuses, GetStatuses.Response))
        app.look()  # asks for the statuses
        drawn(app)
        first, taken = watch.elapsed_s, []
        leaves = [name for name in executive.names if name.startswith("leaf")]
        for number in range(changes):
            leaf = leaves[number // 2 * 7919 % len(leaves)]
            words = "success: so it goes" if number % 2 else "running: so it goes"
            executive.change(1.0, **{leaf: words})
            watch = Stopwatch()
            drawn(app)
            taken.append(watch.elapsed_s)
            await pilot.pause()
    return first, taken


def picture(options: Namespace) -> None:
    """Print how long the first picture and each change take."""
    spare_collections()
    settle_memory()
    firsts, changes = [], []
    for _ in range(PICTURES):
        first, taken = asyncio.run(draw(options.nodes, options.changes))
        firsts.append(first)
        changes += taken
    figures(f"{options.nodes} nodes", {"first picture of a large tree": (times(1e3, firsts), "ms")})
    changes_ms = figure("a change of a large tree", times(1e3, changes), "ms")
    print(
        f"a change {statistics.median(changes_ms):.1f} ms, 99 of 100 below "
        f"{statistics.quantiles(changes_ms, n=100)[98]:.1f} ms ({len(changes)} changes)\n"
    )


def main() -> None:
    """Measure both, or one of them."""
    options = arguments(
        __doc__,
        only={"picture": picture, "slowdown": slowdown},
        turns=5,
        nodes=10_000,
        changes=(100, "of each of five pictures"),
    )
    for part in options.only:
        part(options)


if __name__ == "__main__":
    main()
