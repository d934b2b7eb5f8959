"""The cost of a stage besides its physics: set-up, steps, memory, hundreds of runs.

Run it as: python benchmarks/stage.py [--only fresh|step|memory|scenarios] [--hours 2] [--count 99]
"""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rclpy
from measuring import CpuWatch, figure, in_turns, process_usage, ratios, spread, table
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Empty

from action_servers.server.node import ServerOptions, ServersNode
from bt_mission.core.dds.discovery import isolate
from bt_mission.core.draws import SeededDraws
from bt_mission.core.robot.model import load_robot
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.testing.generators.scenarios import drawn_scenario
from bt_mission.testing.stages import Stages
from bt_mission.virtual_time import VirtualTimeExecutor

LEAN: dict[str, Any] = {"enable_rosout": False, "start_parameter_services": False}
STEPS = 500
WAITS = "mission: waits\ntree: {wait: 10000000}\n"


def fresh(rounds: int) -> None:
    """Measure a stage that is made, stepped once and closed; the first one does not count."""
    mission = load("mission: m\nworld: empty_arena\ntree: {turn: {angle: 9}, timeout: 9}\n")

    def work() -> float:
        watch = Stopwatch()
        with (
            tempfile.TemporaryDirectory() as folder,
            Stage(mission, image_folder=Path(folder)) as s,
        ):
            s.step()
        return watch.elapsed_s * 1000

    work()
    (seconds,) = in_turns(rounds, work)
    figure("a fresh stage", seconds, "ms")
    table(
        ("a fresh stage, after the first", "wall"),
        [("made, stepped, closed", spread(seconds, 0, "ms"))],
    )


class Echo:
    """The nodes of a stage without its world: all action servers idle, and one message each way.

    A control step here is a message to a node that answers it, and everything that follows.
    """

    def __init__(self) -> None:
        self.context = Context()
        rclpy.init(context=self.context)
        robot = load_robot("waffle")
        options = ServerOptions(image_folder=Path(), lean=True, context=self.context)
        servers = ServersNode(robot, options)
        self.talker = Node("talker", context=self.context, **LEAN)
        self.answerer = Node("answerer", context=self.context, **LEAN)
        self.nodes = (servers, self.talker, self.answerer)
        self.received = 0
        self.out = self.talker.create_publisher(Empty, "ask", 10)
        answers = self.answerer.create_publisher(Empty, "answer", 10)
        self.answerer.create_subscription(Empty, "ask", answers.publish, 10)
        self.talker.create_subscription(Empty, "answer", self._hear, 10)

    def _hear(self, _: Empty) -> None:
        self.received += 1

    def close(self) -> None:
        """Destroy the nodes."""
        for node in self.nodes:
            node.destroy_node()
        self.context.shutdown()


def with_stock_executor() -> float:
    """Return the CPU time of a step under rclpy's executor, us."""
    echo = Echo()
    executor = SingleThreadedExecutor(context=echo.context)
    for timer in echo.nodes[0].timers:
        timer.cancel()  # it is on the wall clock here, and would add work
    for node in echo.nodes:
        executor.add_node(node)

    def step() -> None:
        asked = echo.received + 1
        echo.out.publish(Empty())
        while echo.received < asked:
            executor.spin_once(timeout_sec=0)

    return _timed(echo, step, executor)


def with_lockstep_executor() -> float:
    """Return the CPU time of a step under our executor, us."""
    echo = Echo()
    executor = VirtualTimeExecutor(context=echo.context)
    for timer in echo.nodes[0].timers:
        timer.cancel()
    for node in echo.nodes:
        executor.add_node(node)

    def step() -> None:
        echo.out.publish(Empty())
        executor.run_until_quiet()

    timed = _timed(echo, step, executor)
    assert echo.received == 2 * STEPS
    return timed


def _timed(echo: Echo, step: Callable[[], None], executor: Any) -> float:
    for _ in range(STEPS):
        step()
    watch = CpuWatch()
    for _ in range(STEPS):
        step()
    elapsed_us = watch.elapsed_s / STEPS * 1e6
    executor.shutdown()
    echo.close()
    return elapsed_us


def stepping(rounds: int) -> None:
    """Measure our executor against rclpy's, in turns."""
    ours, stock = in_turns(rounds, with_lockstep_executor, with_stock_executor)
    figure("a step of the nodes, CPU", ours, "us")
    figure("the same to rclpy's executor", ratios(ours, stock))
    table(
        ("a control step without physics", "CPU"),
        [
            ("lock-step executor", spread(ours, 0, "us")),
            ("rclpy's SingleThreadedExecutor", spread(stock, 0, "us")),
            ("ratio", spread(ratios(ours, stock), 2)),
        ],
    )


def resident_mib() -> float:
    """Return the memory of this process now, MiB."""
    return process_usage(os.getpid())[1] / 2**20


def memory(hours: float, settle_s: float) -> None:
    """Measure the memory of a stage, and its growth over some hours of virtual time."""
    before = resident_mib()
    mission = load(WAITS)
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(mission, image_folder=Path(folder)) as stage,
    ):
        settled_ns = stage.now_ns + round(settle_s * 1e9)
        end_ns = settled_ns + round(hours * 3600e9)
        while stage.now_ns < settled_ns:
            stage.step()
        at_first = resident_mib()
        while stage.now_ns < end_ns:
            stage.step()
        grown = resident_mib() - at_first
    figure("memory of a stage", at_first - before, "MiB")
    figure("growth of memory a virtual hour", grown / hours, "MiB")
    rows = [
        ("a stage", f"{at_first - before:.1f} MiB"),
        (f"more after {hours:g} virtual hours", f"{grown:.1f} MiB"),
    ]
    table(("memory", "resident"), rows)


def scenarios(count: int) -> None:
    """Drawn scenarios one after the other, on one core."""
    watch, seconds = Stopwatch(), 0.0
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(count):
            stages = Stages(Path(folder))
            run = drawn_scenario(SeededDraws(seed)).on(stages)
            run.until_done()
            seconds += run.t
            stages.close()
    each = watch.elapsed_s / count
    figure("virtual seconds a second", seconds / watch.elapsed_s)
    rows = [
        ("virtual seconds, each", f"{seconds / count:.1f}"),
        ("wall seconds, each", f"{each:.3f}"),
        ("virtual seconds a second", f"{seconds / watch.elapsed_s:.0f}"),
    ]
    table((f"{count} drawn scenarios, one core", "mean"), rows)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=("fresh", "step", "memory", "scenarios"))
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--hours", type=float, default=2.0, help="virtual, for the memory")
    parser.add_argument("--settle", type=float, default=300, help="virtual seconds before them")
    parser.add_argument("--count", type=int, default=100, help="of scenarios")
    options = parser.parse_args()
    isolate(visible=False)
    parts: dict[str, Callable[[], None]] = {
        "fresh": lambda: fresh(3 * options.rounds),
        "step": lambda: stepping(options.rounds),
        "memory": lambda: memory(options.hours, options.settle),
        "scenarios": lambda: scenarios(options.count),
    }
    for name, part in parts.items():
        if options.only in (None, name):
            part()


if __name__ == "__main__":
    main()
