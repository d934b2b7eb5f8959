"""The cost of a stage besides its physics: set-up, steps, memory, hundreds of runs.

Run it as: python benchmarks/stage.py [--only fresh|step|memory|scenarios ...] [--help]
"""

from __future__ import annotations

import os
import tempfile
from argparse import Namespace
from functools import partial
from pathlib import Path
from typing import Any

import rclpy
from measuring import CpuWatch, arguments, figures, in_turns, process_usage, ratios
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


def fresh(options: Namespace) -> None:
    """Measure a stage that is made, stepped once and closed."""
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
    (wall_ms,) = in_turns(3 * options.rounds, work)
    figures("made, stepped, closed; after the first", {"a fresh stage": (wall_ms, "ms")})


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


def cpu_of_a_step(executor_type: type[SingleThreadedExecutor | VirtualTimeExecutor]) -> float:
    """Return the CPU time of a step under an executor, us."""
    echo = Echo()
    executor = executor_type(context=echo.context)
    for timer in echo.nodes[0].timers:
        timer.cancel()  # with rclpy's executor it is on the wall clock, and would add work
    for node in echo.nodes:
        executor.add_node(node)
    for number in range(2 * STEPS):
        if number == STEPS:  # the first ones do not count
            watch = CpuWatch()
        echo.out.publish(Empty())
        if isinstance(executor, VirtualTimeExecutor):
            executor.run_until_quiet()
        while echo.received <= number:
            executor.spin_once(timeout_sec=0)
    elapsed_us = watch.elapsed_s / STEPS * 1e6
    executor.shutdown()
    echo.close()
    return elapsed_us


def step(options: Namespace) -> None:
    """Measure our executor against rclpy's, in turns."""
    works = [partial(cpu_of_a_step, kind) for kind in (VirtualTimeExecutor, SingleThreadedExecutor)]
    ours, stock = in_turns(options.rounds, *works)
    figures(
        "a control step without physics",
        {
            "a step of the nodes, CPU": (ours, "us"),
            "rclpy's SingleThreadedExecutor, CPU": (stock, "us"),
            "the same to rclpy's executor": (ratios(ours, stock), ""),
        },
    )


def resident_mib() -> float:
    """Return the memory of this process now, MiB."""
    return process_usage(os.getpid())[1] / 2**20


def memory(options: Namespace) -> None:
    """Measure the memory of a stage, and its growth over some hours of virtual time."""
    before = resident_mib()
    mission = load(WAITS)
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(mission, image_folder=Path(folder)) as stage,
    ):
        settled_ns = stage.now_ns + round(options.settle * 1e9)
        end_ns = settled_ns + round(options.hours * 3600e9)
        while stage.now_ns < settled_ns:
            stage.step()
        at_first = resident_mib()
        while stage.now_ns < end_ns:
            stage.step()
        grown = resident_mib() - at_first
    figures(
        f"memory, and its growth over {options.hours:g} virtual hours",
        {
            "memory of a stage": (at_first - before, "MiB"),
            "growth of memory a virtual hour": (grown / options.hours, "MiB"),
        },
    )


def scenarios(options: Namespace) -> None:
    """Drawn scenarios one after the other, on one core."""
    watch, seconds, count = Stopwatch(), 0.0, options.count
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(count):
            stages = Stages(Path(folder))
            run = drawn_scenario(SeededDraws(seed)).on(stages)
            run.until_done()
            seconds += run.t
            stages.close()
    figures(
        f"mean of {count} drawn scenarios, one core",
        {
            "a scenario, virtual time": (seconds / count, "s"),
            "a scenario, wall time": (watch.elapsed_s / count, "s"),
            "virtual seconds a second": (seconds / watch.elapsed_s, ""),
        },
    )


def main() -> None:
    """Measure all parts, or some."""
    options = arguments(
        __doc__,
        only={"fresh": fresh, "step": step, "memory": memory, "scenarios": scenarios},
        rounds=7,
        hours=(2.0, "virtual, for the memory"),
        settle=(300.0, "virtual seconds before them"),
        count=(100, "scenarios"),
    )
    isolate(visible=False)
    for part in options.only:
        part(options)


if __name__ == "__main__":
    main()
