"""The same tests give the same traces: in any order, one after another or in two processes."""

from __future__ import annotations

import gc
import random
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from bt_mission.testing.stages import Stages

SCENARIOS = '''
import pytest

TURN = """
mission: turns
inputs: {n: 0}
tree:
  sequence:
    - turn: {angle: "uniform(20, 90)"}
      timeout: 30
      outputs: {angle_turned: turned}
    - log: $turned
"""
UNTIL = """
mission: drives
map: unknown
tree:
  explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.3}
  cancel_when: current_distance_travelled > 0.2
  on_cancel: success
  timeout: 30
"""

@pytest.mark.scenario(seeds=2)
@pytest.mark.parametrize("world", ["empty_arena", "dqn_stage4"])
def test_turns(stage, world):
    assert stage.run(TURN, world=world).until_done().status == "success"

def test_drives(stage):
    run = stage.run(UNTIL, world="dqn_stage4", robot="burger")
    run.record("scan")
    run.until_done()

def test_leaves_in_the_middle(stage):
    stage.run(UNTIL, world="empty_arena").advance(1.0)

def test_scripted(stage, scripted_server):
    turn = scripted_server("turn", accepts=None)
    run = stage.run(TURN, world="empty_arena")
    run.until(lambda s: turn.goals)

def test_two_stages_after_another(stage):
    for seed in (3, 4):
        stage.run(TURN, world="empty_arena", seed=seed).until_done()

def test_fails(stage):
    stage.run(TURN, world="empty_arena").advance(0.3)
    raise ValueError("in the middle of a run")
'''


@pytest.fixture
def scenarios(pytester: pytest.Pytester) -> pytest.Pytester:
    """Scenarios that end, are left, fail, and put servers in place of ours."""
    pytester.makepyfile(test_a=SCENARIOS)
    return pytester


def traces(pytester: pytest.Pytester) -> dict[str, list[str]]:
    """The hashes of the runs of each test, as JUnit's file of the last session has them."""
    return {
        str(case.get("name")): [
            str(element.get("value"))
            for element in case.iter("property")
            if element.get("name") == "trace_sha256"
        ]
        for case in ET.parse(pytester.path / "junit.xml").iter("testcase")  # noqa: S314 - ours
    }


@pytest.mark.thorough
def test_no_test_leaves_a_trace_in_another(scenarios):
    """In one process: each alone at the start, then all in another order."""
    scenarios.runpytest("--junitxml=junit.xml")
    first = traces(scenarios)
    assert sum(map(len, first.values())) == 10
    names = list(first)
    order = random.Random(1).sample(names, len(names))
    scenarios.runpytest("--junitxml=junit.xml", *(f"test_a.py::{name}" for name in order))
    result = traces(scenarios)
    assert list(result) == order
    assert result == first


@pytest.mark.thorough
@pytest.mark.process
def test_workers_do_not_hear_each_other(scenarios):
    """Two processes at once give the traces of one, though all robots have the same topics."""
    scenarios.runpytest_subprocess("--junitxml=junit.xml")
    first = traces(scenarios)
    result = scenarios.runpytest_subprocess("--junitxml=junit.xml", "-n", "2")
    result.assert_outcomes(passed=7, failed=2)
    assert traces(scenarios) == first


TURNS = "mission: turns\ntree: {turn: {angle: 9}, timeout: 9}\n"


def open_sockets() -> int:
    """Sockets that this process has; a DDS participant has five."""
    targets = (link.readlink() for link in Path("/proc/self/fd").iterdir() if link.is_symlink())
    return sum(str(target).startswith("socket:") for target in targets)


@pytest.mark.thorough
def test_closed_stages_hold_no_sockets(tmp_path: Path) -> None:
    """Without the help of the garbage collector, which may not come by for long."""

    def use_a_stage() -> None:
        stages = Stages(tmp_path)
        stages.run(TURNS).until_done()
        stages.close()

    use_a_stage()  # what the first one makes stays for the process
    gc.collect()
    gc.disable()
    try:
        before = open_sockets()
        for _ in range(3):
            use_a_stage()
        assert open_sockets() <= before
    finally:
        gc.enable()
