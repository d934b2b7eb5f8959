"""Real processes: a robot with an arbiter, one of several robots, parameters that do not suit."""

from __future__ import annotations

import json
import signal
from contextlib import ExitStack
from pathlib import Path

import pytest

from bt_mission.testing.live_graph import LOCAL
from tests.support.processes import PATIENCE_S, read_until, started

pytestmark = pytest.mark.process

TWO_ROBOTS = ("--robots", "robot1=waffle@-1,0,0", "robot2=burger@1,0,90")

TURN = """\
mission: turn
tree:
  retry: {attempts: 20, pause: 1}
  do:
    turn: {angle: 30}
    timeout: 30
"""


@pytest.mark.parametrize("command", ["servers", "arbiter"])
def test_a_misspelt_parameter_ends_before_anything_starts(command: str, tmp_path: Path) -> None:
    """With its place, exit code 2, and no traceback."""
    path = tmp_path / "mine.yaml"
    path.write_text("/**:\n  ros__parameters:\n    topics: {cmd_val: x}\n", encoding="utf-8")
    with started(command, "--wall-clock", "--params", str(path), **LOCAL) as process:
        output, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 2
    assert "mine.yaml:3:14: error: no such parameter 'topics.cmd_val'" in output
    assert "did you mean 'topics.cmd_vel'?" in output
    assert "Traceback" not in output


def test_servers_of_a_real_robot_say_that_nobody_listens() -> None:
    """As an error, within a second; the arbiter does the same."""
    for command, topic in (("servers", "/cmd_vel_mission"), ("arbiter", "/cmd_vel")):
        with started(command, "--real", "--params", "waffle", **LOCAL) as process:
            output = read_until(process, "has no subscriber")
            assert f"{topic} has no subscriber; is the robot's bringup running?" in output
            process.send_signal(signal.SIGINT)
            rest, _ = process.communicate(timeout=PATIENCE_S)
            assert "Traceback" not in rest
            assert process.returncode == 0


@pytest.mark.thorough
def test_a_mission_for_one_robot_of_two(tmp_path: Path) -> None:
    """By its namespace: sim, servers and executive as three processes."""
    path = tmp_path / "turn.yaml"
    path.write_text(TURN, encoding="utf-8")
    with ExitStack() as stack:
        sim = stack.enter_context(
            started(
                "sim", "--no-camera", "--speed", "3", *TWO_ROBOTS, "--world", "dqn_stage1", **LOCAL
            )
        )
        servers = stack.enter_context(
            started("servers", "--namespace", "robot2", "--images", str(tmp_path), **LOCAL)
        )
        read_until(sim, "dqn_stage1")
        run = stack.enter_context(
            started("run", str(path), "--attach", "--namespace", "robot2", "--json", **LOCAL)
        )
        out, _ = run.communicate(timeout=PATIENCE_S)
        report = json.loads(out.splitlines()[-1])
        assert (report["status"], report["goals_left_behind"]) == ("success", 0), out
        for process in (servers, sim):
            process.send_signal(signal.SIGINT)
            rest, _ = process.communicate(timeout=PATIENCE_S)
            assert "Traceback" not in rest
