"""Commands by hand as real processes: pipes that close, Ctrl-C, servers that are killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from bt_mission.testing.live_graph import LOCAL
from tests.support.processes import (
    PATIENCE_S,
    ended,
    printed_beside_libraries,
    read_until,
    started,
)

pytestmark = pytest.mark.process

TURNS = """\
mission: turns
tree:
  retry: {attempts: 20, pause: 1}
  do:
    turn: {angle: 15}
    timeout: 30
"""
TALKS = "mission: talks\ntree: {sequence: [{log: one}, {wait: 0.2}, {log: two}]}\n"
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


@pytest.fixture
def start() -> Iterator[Callable[..., Any]]:
    """Start a process that finds others of this machine; it is killed at the end."""
    with ExitStack() as stack:
        yield lambda *words: stack.enter_context(started(*words, **LOCAL))


def test_what_libraries_print_is_not_in_the_output() -> None:
    """Fast DDS prints errors to standard output."""
    assert printed_beside_libraries("actions", "list", "--json") == "[]\n"


@pytest.mark.thorough
def test_an_executive_that_serves_goes_by_other_names(
    start: Callable[..., Any], tmp_path: Path
) -> None:
    """As launch files give them: its namespace and its node, and actions offered and asked for."""
    (tmp_path / "turns.yaml").write_text(
        TURNS,
        encoding="utf-8",
    )
    there = ("--ros-args", "-r", "__ns:=/robot1", "-r", "turn:=rotate")
    mine = (*there, "-r", "__node:=executive", "-r", "execute_mission:=patrol")
    sim, servers = start("sim", "--no-camera", *there), start("servers", *there)
    read_until(sim, "empty_arena")
    read_until(servers, "ready: scan and odometry have come")
    serve = start("serve", "--missions", str(tmp_path), *mine)
    read_until(serve, "/robot1/patrol waits for missions (/clock)")
    ended(start("actions", "send", "/robot1/patrol", "{path: turns.yaml}"), 0)
    offered = ended(start("actions", "list"), 0)
    assert "turns: success" in ended(serve, 0, signal.SIGINT)
    who = {line.split()[0]: line.split()[-1] for line in offered.splitlines() if "/" in line}
    assert who["/robot1/patrol"] == "/robot1/executive"
    assert who["/robot1/rotate"] == "/robot1/bt_mission_servers"
    assert not {"/robot1/execute_mission", "/robot1/turn"} & set(who)


@pytest.mark.thorough
def test_a_mission_is_served_when_the_reader_of_the_output_has_left(
    start: Callable[..., Any], tmp_path: Path
) -> None:
    """It is the client's: what reads the lines, or the disk that takes them, is no part of it."""
    (tmp_path / "talks.yaml").write_text(
        TALKS,
        encoding="utf-8",
    )
    serve = start("serve", "--missions", str(tmp_path), "--wall-clock")
    read_until(serve, "missions of")
    assert serve.stdout is not None
    serve.stdout.close()
    for _ in range(2):
        ended(start("actions", "send", "/execute_mission", "{path: talks.yaml}"), 0)
    assert serve.poll() is None
    serve.send_signal(signal.SIGINT)
    serve.wait(timeout=PATIENCE_S)
