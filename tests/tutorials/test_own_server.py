"""The servers of docs/tutorials/code, called by the mission beside them."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from bt_mission.ros.graph import NodeOptions
from bt_mission.ros.mission_node import MissionNode
from bt_mission.ros.mission_runner import RunnerOptions
from bt_mission.sessions.load import load
from tests.support.processes import PATIENCE_S
from tests.support.project import ROOT
from tests.support.rig import Rig

CODE = ROOT / "docs" / "tutorials" / "code"


def student(file: str, name: str) -> Any:
    """A class of the tutorial's."""
    spec = importlib.util.spec_from_file_location(file, CODE / f"{file}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return getattr(module, name)


class Classroom(Rig):
    """Both servers and a mission on one virtual clock, without a robot."""

    def __init__(self, mission: Any, stack: ExitStack) -> None:
        super().__init__()
        stack.callback(self.close)
        self.logged: list[str] = []
        context = self.context
        self.fibonacci = self.add(student("fibonacci_server", "FibonacciServer")(context=context))
        self.add(student("adder_server", "AdderServer")(context=context))
        options = RunnerOptions(say=self.logged.append, has_controls=False, has_presence=False)
        node = NodeOptions(context=context, lean=True)
        self.mission = self.add(MissionNode(mission, options, node=node))
        while not self.mission.runner.executive.is_done:
            self.step()
            assert self.now_s < 60


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    """Closes what a test has opened."""
    with ExitStack() as opened:
        yield opened


def test_the_mission_counts_adds_and_cancels(stack: ExitStack) -> None:
    """Ten numbers after four seconds; six of forty, since the cancel comes after the fifth."""
    room = Classroom(load(CODE / "numbers.yaml"), stack)
    executive = room.mission.runner.executive
    assert (str(executive.status), executive.reason) == ("success", "")
    assert room.logged == [
        "numbers: 0, 1, 1, 2, 3, 5, 8, 13, 21, 34",
        "total: 110",
        "a few: 0, 1, 1, 2, 3, 5",
    ]
    assert executive.goals_left_behind == ()
    assert room.now_s == pytest.approx(4.0 + 2.0, abs=0.3)


def test_the_server_serves_the_next_goal_after_a_cancel(stack: ExitStack) -> None:
    """No timer of the cancelled goal is left, and no number of it."""
    action = "action: {name: /fibonacci, type: example_interfaces/action/Fibonacci, goal: "
    room = Classroom(
        load(
            "mission: m\ntree:\n  sequence:\n    - fallback:\n"
            f"        - {action}{{order: 40}}}}\n          timeout: 1.2\n"
            "        - log: cut short\n"
            f"    - {action}{{order: 3}}}}\n      timeout: 5\n      outputs: {{sequence: all}}\n"
            "    - log: $all\n"
        ),
        stack,
    )
    assert str(room.mission.runner.executive.status) == "success"
    assert room.logged == ["cut short", "0, 1, 1"]
    assert list(room.fibonacci.timers) == []


@pytest.mark.parametrize("order", ["0", "50"])
def test_an_order_that_makes_no_sense_is_rejected(stack: ExitStack, order: str) -> None:
    """And the mission hears of it at once."""
    room = Classroom(load(CODE / "numbers.yaml", set={"order": order}), stack)
    executive = room.mission.runner.executive
    assert str(executive.status) == "failure"
    assert executive.reason.startswith("'fibonacci' rejected: ")
    assert room.now_s < 0.5


@pytest.mark.thorough
@pytest.mark.process
def test_three_terminals(tmp_path: Path) -> None:
    """As the page says: two servers and a mission, each a process of its own."""
    environment = os.environ | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    with ExitStack() as stack:
        for name in ("fibonacci_server", "adder_server"):
            server = stack.enter_context(
                subprocess.Popen([sys.executable, str(CODE / f"{name}.py")], env=environment)
            )
            stack.callback(server.kill)
        mission = [sys.executable, "-m", "bt_mission", "run", str(CODE / "numbers.yaml")]
        done = subprocess.run(
            [*mission, "--attach", "--wall-clock"],
            env=environment,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )
    assert done.returncode == 0, done.stdout + done.stderr
    for output in (
        "numbers: 0, 1, 1, 2, 3, 5, 8, 13, 21, 34",
        "total: 110",
        "a few: 0, 1, 1, 2, 3",
    ):
        assert output in done.stdout
