"""A mission on a program's own node, while ROS is shut down by the handlers that rclpy installs."""

from __future__ import annotations

import os
import signal
import sys
from types import SimpleNamespace
from typing import Any

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.ros import graph, run_ending
from bt_mission.ros.mission_node import MissionNode
from bt_mission.ros.mission_runner import RunnerOptions
from bt_mission.sessions.load import load
from bt_mission.testing import LiveGraph, ScriptedServer
from tests.support.graph import TURN
from tests.support.thorough import sample

PROGRAM = """
import sys

import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.executors import ExternalShutdownException

import bt_mission

rclpy.init()
node = rclpy.create_node("my_robot")
mission = bt_mission.load("mission: m\\ntree: {turn: {angle: 3000}, timeout: 90}\\n")
try:
    with bt_mission.MissionRunner(node, mission) as runner:
        is_said = False
        while not runner.is_done:
            rclpy.spin_once(node, timeout_sec=0.1)
            goals = runner.ledger.open_goals
            if not is_said and goals and goals[0].accepted:
                print("the goal is accepted", flush=True)
                is_said = True
except (KeyboardInterrupt, ExternalShutdownException):
    pass
except TypeError as error:  # what rclpy makes of an interrupt while it converts a message
    if not isinstance(error.__cause__, KeyboardInterrupt):
        raise
except RCLError:  # ROS was shut down while rclpy prepared to wait
    if rclpy.ok():
        raise
phases = {str(goal.phase) for goal in goals}
print(runner.status, phases, runner.report().reason, sep="; ", flush=True)
"""


@pytest.mark.thorough
@pytest.mark.process
@pytest.mark.parametrize("name", sample(["SIGINT", "SIGTERM"], 2))
def test_a_goal_is_seen_to_its_end_after_ros_was_shut_down(
    live_graph: LiveGraph, name: str
) -> None:
    """It is cancelled, its end is heard over another context, and nothing is orphaned."""
    live_graph.robot("empty_arena")
    file = live_graph.folder / "program.py"
    file.write_text(PROGRAM, encoding="utf-8")
    program = live_graph.start_program("program", sys.executable, str(file))
    program.until("the goal is accepted")
    os.kill(program.pid, signal.Signals[name])
    assert program.wait(within=60) == 0, program.output
    output = program.output.splitlines()[-1]
    assert output.startswith("interrupted; {'ended'}; its caller has left: "), program.output
    assert "orphaned" not in output


@pytest.mark.thorough
@pytest.mark.process
def test_a_goal_whose_server_does_not_answer_is_named(live_graph: LiveGraph) -> None:
    """With what is known of it, within the time that a cancel has."""
    _, servers = live_graph.robot("empty_arena")
    file = live_graph.folder / "program.py"
    file.write_text(PROGRAM, encoding="utf-8")
    program = live_graph.start_program("program", sys.executable, str(file))
    program.until("the goal is accepted")
    os.kill(servers.pid, signal.SIGSTOP)
    os.kill(program.pid, signal.SIGINT)
    assert program.wait(within=60) == 0, program.output
    output = program.output.splitlines()[-1]
    assert output.startswith("interrupted; {'lost'}; its caller has left: "), program.output
    assert "orphaned goals: /turn goal " in output
    os.kill(servers.pid, signal.SIGCONT)


def test_what_rclpy_raises_while_ros_is_shut_down_abandons_nothing() -> None:
    """The goals are then seen to their end over another context."""
    context = rclpy.Context()
    context.init()

    class Ending(SingleThreadedExecutor):
        def spin_once(self, timeout_sec: float | None = None) -> None:
            context.shutdown()
            raise RuntimeError(f"no timer of {timeout_sec} s can be made")

    runner: Any = SimpleNamespace(
        is_done=False,
        executive=SimpleNamespace(cleanups=SimpleNamespace(limit_s=0.0), abandon=pytest.fail),
    )
    executor = Ending(context=context)
    run_ending._spin(runner, executor, Stopwatch())
    assert not context.ok()
    executor.shutdown()


@pytest.mark.parametrize(
    ("text", "reasons"),
    [
        ("jammed", ["a callback failed: ValueError: jammed (test_run_ending.py:"]),
        (run_ending.SPUN_ELSEWHERE, []),
    ],
)
def test_a_value_error_of_a_callback_abandons_the_mission(text: str, reasons: list[str]) -> None:
    """That of an executor which another thread spins does not: the node is spun there."""
    context = rclpy.Context()
    context.init()
    abandoned: list[str] = []

    class Failing(SingleThreadedExecutor):
        def spin_once(self, timeout_sec: float | None = None) -> None:
            runner.is_done = True
            raise ValueError(text)

    runner: Any = SimpleNamespace(
        is_done=False,
        executive=SimpleNamespace(cleanups=SimpleNamespace(limit_s=0.0), abandon=abandoned.append),
    )
    executor = Failing(context=context)
    run_ending._spin(runner, executor, Stopwatch())
    assert [reason[: len(reasons[0])] for reason in abandoned] == reasons
    executor.shutdown()
    context.shutdown()


def test_goals_that_nobody_confirms_do_not_keep_a_mission_in_a_graph_from_ending(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The bound is one of wall time, and the goal is named."""
    monkeypatch.setattr(graph, "END_WAIT_S", 0.0)
    with graph.GraphConnection(wall_clock=True) as connection:
        mission = load("mission: m\ntree: {turn: {angle: 90}, timeout: 60}\n")
        options = graph.NodeOptions(context=connection.context, lean=True)
        node = MissionNode(mission, RunnerOptions(has_presence=False), node=options)
        connection.host(node)
        turn = ScriptedServer(connection.host_quiet("servers"), TURN, "turn", cancels=None)
        executive = node.runner.executive
        while not (turn.goals and turn.goal.accepted):
            connection.step(executive, node)
        executive.interrupt("enough")
        while not executive.is_done:
            connection.step(executive, node)
        connection.drop(node)
    assert executive.status == "interrupted"
    assert "not every goal had ended after 0 s; orphaned goals: /turn goal " in executive.reason
