"""Facts about the mapper as a process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger

from tests.support.processes import PATIENCE_S


@pytest.fixture
def user(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Node, SingleThreadedExecutor]]:
    """Somebody whom other processes of this machine can see."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    context = Context()
    rclpy.init(context=context)
    node = Node("user", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    yield node, executor
    executor.shutdown()
    node.destroy_node()
    context.shutdown()


@pytest.mark.process
def test_the_command_serves_until_it_is_interrupted(
    user: tuple[Node, SingleThreadedExecutor], tmp_path: Path
) -> None:
    """It answers that there is no map yet, and leaves with exit code 0."""
    node, executor = user
    command = [sys.executable, "-m", "bt_mission", "mapper", "--wall-clock", "--save-as"]
    with (
        subprocess.Popen([*command, str(tmp_path / "map")], env=dict(os.environ)) as mapper,
        ExitStack() as last,
    ):
        last.callback(mapper.kill)  # a failed assertion must not wait for it
        saver = node.create_client(Trigger, "save_map")
        assert saver.wait_for_service(timeout_sec=60.0)
        answer = saver.call_async(Trigger.Request())
        executor.spin_until_future_complete(answer, timeout_sec=30.0)
        result = answer.result()
        assert result is not None
        assert (result.success, result.message[:19]) == (False, "there is no map yet")
        mapper.send_signal(signal.SIGINT)
        assert mapper.wait(timeout=PATIENCE_S) == 0
