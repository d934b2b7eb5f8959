"""Facts about the servers as a process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import ExitStack
from typing import Any

import pytest
import rclpy
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor

from action_servers.core.maneuver import ZERO
from tests.support.processes import PATIENCE_S
from tests.support.thorough import sample

PROGRAM = """
from pathlib import Path
from action_servers.server.node import main
raise SystemExit(main(robot="waffle", image_folder=Path({folder!r})))
"""


@pytest.fixture
def live(fake, waffle, robot_node, monkeypatch):
    """A robot on the wall clock that other processes of this machine can see."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    context = rclpy.Context()
    rclpy.init(context=context)
    robot = robot_node(fake(waffle), context, 10_000_000_000)
    robot.next_due_ns = robot.get_clock().now().nanoseconds
    robot.create_timer(0.05, lambda: robot.advance_to(robot.get_clock().now().nanoseconds))
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(robot)

    def spin_until(done: Any) -> None:
        for _ in range(2400):  # twenty a second: the process may begin late on a busy machine
            if done():
                return
            executor.spin_once(timeout_sec=0.5)
        raise AssertionError("nothing came of it")

    yield robot, spin_until
    robot.destroy_node()
    executor.shutdown()
    context.shutdown()


@pytest.mark.process
@pytest.mark.parametrize("number", sample([signal.SIGINT, signal.SIGTERM], every=2))
def test_a_signal_stops_the_robot_ends_the_goal_and_leaves_cleanly(live, tmp_path, number):
    """Zero velocity, an aborted goal with its reason, exit code 0."""
    robot, spin_until = live
    with (
        subprocess.Popen(
            [sys.executable, "-c", PROGRAM.format(folder=str(tmp_path))],
            env=dict(os.environ),
            stderr=subprocess.PIPE,
            text=True,
        ) as servers,
        ExitStack() as last,
    ):
        last.callback(servers.kill)  # a failed assertion must not wait for it
        client = ActionClient(robot, Turn, "turn")
        spin_until(client.server_is_ready)
        handle: Any = None
        while handle is None or not handle.accepted:  # until the servers have heard of the robot
            answer = client.send_goal_async(Turn.Goal(angle=3600.0))
            spin_until(answer.done)
            handle = answer.result()
        result = handle.get_result_async()
        spin_until(lambda: robot.command.angular == 1.0)
        servers.send_signal(number)
        spin_until(result.done)
        spin_until(lambda: robot.command == ZERO)
        assert result.result().result.error_msg == (
            f"the action servers were stopped by {number.name}"
        )
        assert servers.wait(timeout=PATIENCE_S) == 0
        assert servers.stderr is not None
        assert "Traceback" not in servers.stderr.read()
    assert robot.command == ZERO
