"""What it costs to look on at a mission, and how fast the view is on a large tree.

Slow-down: a mission runs on the stage as fast as it goes; in turns nobody looks on, and `bt-mission
watch` does on a terminal of its own. Measured is the share of the stage's thread that goes into
telling: processor time within what publishes for tools, of all processor time of the thread. Both
are of one process and one run, so that a busy machine does not count. The slow-down is by how much
that share makes a mission longer, against the same without a watcher. What the middleware's own
threads take is printed beside it: it is spent on other cores.

Large tree: the full-screen view, driven by Textual's pilot, is given a tree of ten thousand nodes.
The first picture is the time from the serialised messages (the tree, all statuses) to the drawn
screen; a change is
the time from StatusChanges of one node to the drawn screen.

Run it as: python benchmarks/watching.py [--turns N] [--nodes N] [--only slowdown|picture]
"""

from __future__ import annotations

import argparse
import asyncio
import os
import pty
import select
import signal
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from bt_mission_interfaces.msg import NodeStatus, Tree, TreeNode
from bt_mission_interfaces.srv import GetStatuses
from measuring import figure
from py_trees.common import Status
from rclpy.serialization import deserialize_message, serialize_message

from bt_mission.core.memory import settle_memory, spare_collections
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.events import events, reader
from bt_mission.events.messages import Batch
from bt_mission.events.source import ControlRequest, ListedExecutive, Received
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageOptions
from bt_mission.views.terminal.marks import SIGNS
from bt_mission.views.tui.app import WatchApp

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
S = 1_000_000_000


# ---- slow-down -------------------------------------------------------------------------------


@contextmanager
def watcher(arguments: tuple[str, ...]) -> Iterator[int]:
    """Start `bt-mission watch` on a terminal. Return the terminal's file, which has to be read."""
    child, terminal = pty.fork()
    if child == 0:
        os.environ |= {"TERM": "xterm-256color", "LINES": "45", "COLUMNS": "140"}
        os.execv(sys.executable, [sys.executable, "-m", "bt_mission", "watch", *arguments])  # noqa: S606 - ourselves
    try:
        yield terminal
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        os.close(terminal)


def drain(terminal: int | None) -> None:
    """Read what the viewer has drawn, as a terminal would."""
    while terminal is not None and select.select([terminal], [], [], 0)[0]:
        os.read(terminal, 65536)


@dataclass
class Cost:
    """Processor time of a turn, s: publishing, the stage's thread, and all other threads."""

    telling: float = 0.0
    thread: float = 0.0
    others: float = 0.0

    @property
    def slowdown(self) -> float:
        """The relative increase of the mission's time by publishing."""
        return self.telling / (self.thread - self.telling)


class Meter:
    """Measures the functions after each tick: all that is published for tools."""

    def __init__(self, stage: Stage) -> None:
        self.telling = 0.0
        listeners = stage.executive.after_tick
        listeners[:] = [partial(self._measure, listener) for listener in listeners]

    def _measure(self, listener: Callable[[], None]) -> None:
        start = time.thread_time()
        listener()
        self.telling += time.thread_time() - start


def turn(stage: Stage, meter: Meter, terminal: int | None) -> Cost:
    """The cost of a turn."""
    start_ns = stage.now_ns
    before = (meter.telling, time.thread_time(), time.process_time())
    while stage.now_ns - start_ns < VIRTUAL_S * S:
        for _ in range(50):
            stage.step()
        drain(terminal)
    if terminal is not None and not stage.node.count_subscribers(DETAILS):
        raise SystemExit("the watcher has left")
    after = (meter.telling, time.thread_time(), time.process_time())
    telling, thread, process = (new - old for new, old in zip(after, before, strict=True))
    return Cost(telling, thread, process - thread)


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


def measure_slowdown(turns: int, arguments: tuple[str, ...]) -> None:
    """Print how much more processor time a watched mission takes."""
    mission = load(MISSION)
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(
            mission,
            image_folder=Path(folder),
            say=lambda _: None,
            options=StageOptions(visible=True),
        ) as stage,
    ):
        meter = Meter(stage)
        turn(stage, meter, None)  # imports, and the first frames
        alone, seen = [], []
        for _ in range(turns):
            alone.append(turn(stage, meter, None))
            with watcher(arguments) as terminal:
                attach(stage, terminal)
                seen.append(turn(stage, meter, terminal))
            while stage.node.count_subscribers(DETAILS):
                stage.step()
    slowdowns = [
        watched.slowdown - other.slowdown for watched, other in zip(seen, alone, strict=True)
    ]
    name = " ".join(("watch", *arguments))
    figure(f"{name}: slow-down", (100 * slowdown for slowdown in slowdowns), "%")
    print(
        f"{' '.join(('watch', *arguments))}: slow-down {statistics.median(slowdowns):+.2%}, spread "
        f"{min(slowdowns):+.2%} to {max(slowdowns):+.2%}; {turns} turns of {VIRTUAL_S:g} s, "
        f"{median_ms(run.thread for run in alone):.1f} ms a virtual second, other threads "
        f"{median_ms(run.others for run in alone):.1f} ms alone and "
        f"{median_ms(run.others for run in seen):.1f} ms watched"
    )


def median_ms(times_s: Iterable[float]) -> float:
    """The median of turns, ms a virtual second."""
    return statistics.median(times_s) / VIRTUAL_S * 1e3


# ---- a large tree ----------------------------------------------------------------------------


class Large:
    """An executive with a tree of some nodes, whose leaves run one after another."""

    name = "/bt_mission"
    limits = ""
    is_there = True
    where = "a benchmark"

    def __init__(self, count: int) -> None:
        nodes = [events.NodeInfo("large", "Sequence", "0", 0)]
        while len(nodes) < count:
            place = len(nodes)
            part = (place - 1) // (CHILDREN + 1) * (CHILDREN + 1) + 1
            is_part = place == part
            kind, parent = ("Sequence", 0) if is_part else ("ActionLeaf", part)
            name = f"part {place}" if is_part else f"leaf {place}"
            nodes.append(events.NodeInfo(name, kind, f"0.{place}", parent))
        self.tree = events.RunStarted(S, "run", "large", tuple(nodes))
        self.received = Received()

    def serve(self) -> None:
        """Do nothing: there is no network."""

    def find(self) -> tuple[ListedExecutive, ...]:
        """Return this executive."""
        return (ListedExecutive(self.name),)

    def attach(self, _name: str) -> Large:
        """Return this executive."""
        return self

    def take(self, *, needs_statuses: bool) -> Received:
        """Return the prepared messages, once."""
        del needs_statuses
        received, self.received = self.received, Received()
        return received

    def send(self, command: ControlRequest) -> None:
        """Drop a request."""

    def close(self) -> None:
        """Do nothing: there is no connection."""


def wire(tree: events.RunStarted) -> tuple[bytes, bytes]:
    """Return the tree, and the response with all its statuses, as sent over the network."""
    nodes = [
        TreeNode(name=node.name, kind=node.kind, path=node.path, parent=node.parent)
        for node in tree.nodes
    ]
    message = Tree(run=tree.run, mission=tree.mission, nodes=nodes)
    message.stamp.sec = 1
    statuses = [NodeStatus(node=index) for index in range(len(nodes))]
    answer = GetStatuses.Response(run=tree.run, statuses=statuses)
    return serialize_message(message), serialize_message(answer)


def drawn(large: Large, app: WatchApp, receive: Callable[[], Received]) -> float:
    """Wall time from a message to the drawn screen, s."""
    watch = Stopwatch()
    large.received = receive()
    app.look()
    app.screen._compositor.render_strips()  # noqa: SLF001 - what the pilot's driver does not do
    return watch.elapsed_s


async def draw(nodes: int, changes: int) -> tuple[float, list[float]]:
    """Seconds to the first picture, and of each change."""
    large = Large(nodes)
    tree, answer = wire(large.tree)

    def begin() -> Received:
        return Received(
            (
                reader.tree(deserialize_message(tree, Tree)),
                Batch("run", (events.StateChanged(S, "run", "large", "running", ""),)),
                reader.statuses(deserialize_message(answer, GetStatuses.Response)),
            )
        )

    app = WatchApp(large, SIGNS)
    async with app.run_test(size=(140, 45)) as pilot:
        await pilot.pause()
        first = drawn(large, app, begin)
        taken, index = [], 0
        for number in range(1, changes + 1):
            starts = number % 2 == 1
            index = 2 + number * 7919 % (nodes - 2) if starts else index
            status = Status.RUNNING if starts else Status.SUCCESS
            change = events.NodeChanged(S + number * S, index, status, "so it goes")
            received = Received((Batch("run", (change,), number),))
            taken.append(drawn(large, app, lambda received=received: received))
            await pilot.pause()
    return first, taken


def measure_picture(nodes: int, count: int) -> None:
    """Print how long the first picture and each change take."""
    spare_collections()
    settle_memory()
    firsts, changes = [], []
    for _ in range(PICTURES):
        first, taken = asyncio.run(draw(nodes, count))
        firsts.append(first)
        changes += taken
    figure("first picture of a large tree", (1000 * first_s for first_s in firsts), "ms")
    figure("a change of a large tree", (1000 * change_s for change_s in changes), "ms")
    print(
        f"{nodes} nodes: first picture {statistics.median(firsts) * 1e3:.0f} ms, at most "
        f"{max(firsts) * 1e3:.0f}; a change {statistics.median(changes) * 1e3:.1f} ms, 99 of 100 "
        f"below {statistics.quantiles(changes, n=100)[98] * 1e3:.1f} ({len(changes)} changes)"
    )


def main() -> None:
    """Measure both, or one of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--nodes", type=int, default=10_000)
    parser.add_argument("--changes", type=int, default=100, help="of each of five pictures")
    parser.add_argument("--only", choices=("slowdown", "picture"))
    options = parser.parse_args()
    if options.only != "slowdown":
        measure_picture(options.nodes, options.changes)
    if options.only != "picture":
        measure_slowdown(options.turns, ())
        measure_slowdown(options.turns, ("--json",))


if __name__ == "__main__":
    main()
