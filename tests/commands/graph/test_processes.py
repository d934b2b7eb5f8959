"""Commands by hand as real processes: pipes that close, Ctrl-C, servers that are killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import ExitStack
from typing import Any

import pytest

from bt_mission.testing.live_graph import LOCAL
from tests.support.processes import PATIENCE_S, read_until, started

pytestmark = pytest.mark.process

WAIT = ("--type", "nav2_msgs/action/Wait", "--wait", "20")


@pytest.fixture
def robot() -> Any:
    """A simulation and its servers, as two processes."""
    with ExitStack() as stack:
        sim = stack.enter_context(started("sim", "--no-camera", **LOCAL))
        servers = stack.enter_context(started("servers", **LOCAL))
        read_until(sim, "empty_arena")
        yield servers


@pytest.mark.thorough
def test_by_hand_against_servers_in_other_processes(robot: Any) -> None:
    """A pipe that closes, Ctrl-C, and a server that is killed: no traceback, each its code."""
    send = ("actions", "send", "/wait", "time: 60", *WAIT)
    with started(*send, **LOCAL) as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.stdout.close()
        assert process.wait(timeout=PATIENCE_S) == 4, "its goal was cancelled"
    with started(*send, **LOCAL) as process:
        seen = read_until(process, "time_left")
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 4
        assert "canceled: interrupted by Ctrl-C after" in rest
    listing = f"{sys.executable} -m bt_mission actions list | head -1"
    result = subprocess.run(
        ["/bin/bash", "-o", "pipefail", "-c", listing],
        env=os.environ | LOCAL,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert result.stdout.startswith("/backup ")
    assert result.stderr == ""
    with started(*send, **LOCAL) as process:
        seen += read_until(process, "time_left")
        robot.kill()
        rest, _ = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 6
        assert "/wait has gone from the graph; orphaned goal: /wait goal" in rest
    assert "Traceback" not in seen + rest
