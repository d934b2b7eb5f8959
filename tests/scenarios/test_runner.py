"""Many scenarios in one process: each is as in a process of its own, and leaves nothing there."""

from __future__ import annotations

import gc
import json
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from rclpy.logging import LoggingSeverity, set_logger_level

from bt_mission.base.dds.discovery import RANGE
from bt_mission.base.dds.middleware import ALONE, PROFILES
from bt_mission.base.errors import BtMissionError
from bt_mission.scenarios.runner import ScenarioProcess, prepare_process, silence_logs
from bt_mission.sessions.stage import Stage
from bt_mission.testing.live_graph import command
from sim.physics.physics import Physics

TURN = """\
scenario: turn
mission:
  mission: turns
  world: empty_arena
  tree: {turn: {angle: "uniform(5, 10)"}, timeout: 20}
"""
LEG = "scenario: leg\nmission: square\ninputs: {side: 0.3}\n"
WRONG = "faults: ['at 0.5: drop no_such_topic']\n"
FAULTY = "faults: ['at 0.5: spawn_box ahead 1.0', 'at 1.0: drop scan lasting 0.3']\n"


@pytest.fixture
def runner() -> Iterator[ScenarioProcess]:
    """One where Python does not look for cycles by itself, as little as it does that."""
    gc.disable()
    try:
        yield ScenarioProcess()
    finally:
        gc.enable()
        gc.unfreeze()


@pytest.fixture
def written(tmp_path: Path):
    """``written(name, text)``: a scenario's file."""

    def write(name: str, text: str) -> Path:
        path = tmp_path / f"{name}.scenario.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def by_itself(*arguments: object) -> str:
    """The hash of the trace of ``bt-mission run``, a process for one run."""
    done = subprocess.run(
        command("run", *map(str, arguments), "--json"), capture_output=True, text=True, check=True
    )
    reported: str = json.loads(done.stdout)["trace_sha256"]
    return reported


@pytest.mark.thorough
def test_a_later_run_is_that_of_a_process_of_its_own(runner, written):
    """With the mission's file as with the scenario's; whatever ran before, and broke."""
    turn, leg = written("turn", TURN), written("leg", LEG)
    faulty = written("faulty", LEG + FAULTY)
    for seed in range(2):
        runner.run(turn, seed=seed)
    with pytest.raises(BtMissionError):
        runner.run(written("wrong", TURN + WRONG))
    first = [
        runner.run(scenario, seed=3).report.trace_sha256 for scenario in (leg, faulty, leg, faulty)
    ]
    assert first[:2] == first[2:]
    assert first[0] == by_itself(leg, "--seed", 3)
    assert first[1] == by_itself(faulty, "--seed", 3)


def in_use() -> tuple[int, int, int]:
    """Stages and models that Python has not freed; files that are open; threads."""
    alive = [value for value in gc.get_objects() if type(value) in (Stage, Physics)]
    files, threads = (len(list(Path("/proc/self", folder).iterdir())) for folder in ("fd", "task"))
    return len(alive), files, threads


def test_nothing_of_a_run_stays(runner, written):
    """Neither where it came to an end nor where its stage could not be set up."""
    turn, wrong = written("turn", TURN), written("wrong", TURN + WRONG)
    runner.run(turn)
    before = in_use()
    for seed in range(3):
        runner.run(turn, seed=seed)
        assert in_use() == before
    with pytest.raises(BtMissionError):
        runner.run(wrong)
    runner.run(turn)
    assert in_use() == before


def test_no_process_is_to_find_one_that_only_runs_scenarios(monkeypatch):
    """It needs no port, and no shared memory, of which there is little in a container."""
    for name in (RANGE, *PROFILES):
        monkeypatch.setenv(name, "")
    prepare_process()
    assert os.environ[RANGE] == "OFF"
    assert os.environ[PROFILES[0]] == str(ALONE)


def test_nodes_of_its_runs_print_no_warnings(runner, written, capfd):
    """Neither those of the robot, which are quiet anyway, nor others."""
    silence_logs()
    try:
        runner.run(written("turn", TURN + "faults: ['at 0.1: delay cmd_vel by 0.5 lasting 1']\n"))
    finally:
        set_logger_level("", LoggingSeverity.INFO)
    assert capfd.readouterr().err == ""


def test_a_scenario_is_given_back_with_what_it_reached(runner, written):
    """As from `run_scenario`."""
    result = runner.run(written("turn", TURN), seed=2, with_coverage=True)
    assert result.scenario.mission.seed == 2
    assert result.coverage is not None
    assert result.coverage.reached == ("0 turn: reached", "0 turn: outcome succeeded")
