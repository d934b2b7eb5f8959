"""``bt-mission run --fault``: what is made, what is said, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from bt_mission.cli import main

TURN = "mission: turns\nworld: empty_arena\ntree:\n  turn: {angle: 90}\n  timeout: 20\n"


@pytest.fixture
def turn(tmp_path: Path) -> str:
    """A mission of one turn, which takes 1.9 s."""
    path = tmp_path / "turns.yaml"
    path.write_text(TURN, encoding="utf-8")
    return str(path)


def test_faults_are_said_as_they_happen_and_at_the_end(
    turn: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """With their times; also what never happened."""
    late = ["--fault", "at 60: lidar_dead"]
    assert main(["run", turn, "--fault", "at 0.5: drop imu lasting 0.5", *late]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "     0.50 s    fault 1 begins: drop topic imu" in lines
    assert "     1.00 s    fault 1 ends: drop" in lines
    assert lines[-2] == "  fault at 0.5: drop imu lasting 0.5: from 0.50 s to 1.00 s"
    assert lines[-1].startswith("  fault at 60.0: lidar_dead: never happened, the mission ended at")


def test_faults_are_in_json_and_in_the_trace(
    turn: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """And the mission answers them: the server dies, and the goal is orphaned."""
    trace = tmp_path / "run.trace"
    fault = "when speed < 1 and time >= 0.5: kill_server turn"
    assert main(["run", turn, "--fault", fault, "--json", "--trace", str(trace)]) == 1
    told: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert told["faults"] == [{"fault": fault, "began": 0.5, "ended": None, "why": ""}]
    assert told["goals_left_behind"] == 1
    assert '"event": "fault"' in trace.read_text()


def test_two_runs_with_the_same_faults_have_the_same_trace(
    turn: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """To the last byte; another fault makes another trace."""
    hashes = []
    for share in (0.5, 0.5, 0.4):
        main(["run", turn, "--fault", f"at 0.2: drop odom share {share} lasting 1", "--json"])
        hashes.append(json.loads(capsys.readouterr().out)["trace_sha256"])
    assert hashes[0] == hashes[1] != hashes[2]


@pytest.mark.parametrize(
    ("fault", "place", "words"),
    [
        ("at 5: drp scan", "--fault:1:7", "did you mean 'drop'?"),
        ("at 1: drop scna", "--fault:1:12", "there is no topic '/scna'"),
        ("at 1: kill_server trun", "--fault:1:19", "there is no action '/trun'"),
        ('when running("trn"): imu_dead', "--fault:1:6", "no node is named 'trn'"),
        ("at 1: move_box chair ahead 1", "--fault:1:1", "no obstacle that was spawned 'chair'"),
    ],
)
def test_a_fault_on_nothing_exits_with_2_and_points_at_it(
    turn: str, capsys: pytest.CaptureFixture[str], fault: str, place: str, words: str
) -> None:
    """Before anything moves, where that can be known."""
    assert main(["run", turn, "--fault", fault]) == 2
    err = capsys.readouterr().err
    assert f"{place}: error: " in err
    assert words in err
    assert f"    {fault}\n" in err


def test_an_attached_run_has_no_faults_of_ours(
    turn: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is refused with the reason."""
    assert main(["run", turn, "--attach", "--fault", "at 5: imu_dead"]) == 2
    assert "faults are made in a simulation" in capsys.readouterr().err
