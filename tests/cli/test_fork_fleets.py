"""Forks of recorded fleets: all robots run again, and the run of one is changed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from bt_mission.cli import main
from tests.support.forks import forked, refused
from tests.support.recordings import with_facts

FLEET = """\
fleet: pair
world: dqn_stage1
seed: 3
robots:
  one:
    mission:
      mission: turns
      inputs: {angle: 90}
      requirements: {is slow: always speed < 1}
      tree:
        sequence:
          - {turn: {angle: $angle}, name: turn, timeout: 20}
          - {turn: {angle: $angle}, name: again, timeout: 20}
    inputs: {angle: 60}
    start: {x: -1}
  two:
    mission: drives.yaml
    robot: burger
    start: {x: 1, yaw: 90}
"""
DRIVES = """\
mission: drives
inputs: {speed: 0.1}
tree:
  sequence:
    - {wait: 1, name: a while}
    - explore_forward: {fwd_velocity: $speed, stopping_distance: 0.3}
      name: drive
      cancel_when: current_distance_travelled >= 0.2
      on_cancel: success
      timeout: 20
"""
FAULT = "one: at 0.5: drop imu lasting 0.5"


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A recorded fleet with nature and a fault, the files of which are gone."""
    folder = tmp_path_factory.mktemp("fleet")
    (folder / "it.yaml").write_text(FLEET, encoding="utf-8")
    (folder / "drives.yaml").write_text(DRIVES, encoding="utf-8")
    files = ["--record", str(folder / "run.mcap"), "--trace", str(folder / "run.jsonl")]
    words = [*files, "--fault", FAULT, "--nature", "usual", "--set", "angle=70"]
    assert main(["run", str(folder / "it.yaml"), "--json", *words]) == 0
    (folder / "it.yaml").unlink()
    (folder / "drives.yaml").unlink()
    return str(folder / "run.mcap")


def test_without_a_change_the_same_happens_again_to_every_robot(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """From the recording alone: with starts, models, nature, inputs and faults of each robot."""
    found = forked(capsys, run, "--at", "2", "--trace", str(tmp_path / "again.jsonl"))
    assert (found["robot"], found["is_identical"]) == ("one", True)
    assert [(one["robot"], one["is_identical"]) for one in found["others"]] == [("two", True)]
    assert found["forked"]["faults"][0]["ended"] == 1.0
    for robot in ("one", "two"):
        again = (tmp_path / f"again.{robot}.jsonl").read_bytes()
        assert again == Path(run).with_name(f"run.{robot}.jsonl").read_bytes()


def test_the_run_of_one_robot_is_changed(run: str, capsys: pytest.CaptureFixture[str]) -> None:
    """It is shown first, then what became of the others."""
    assert main(["fork", run, "--robot", "two", "--at", "0.5", "--set", "speed=0.2"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("two: recorded: success at ")
    assert lines[1].startswith("forked at 0.50 s with speed=0.2: success at ")
    (at,) = (number for number, line in enumerate(lines) if line.startswith("one: recorded: "))
    assert lines[at + 1].startswith("forked at 0.50 s with two: speed=0.2: success at ")
    fault = forked(
        capsys, run, "--robot", "two", "--at", "1", "--fault", "at 2: lidar_dead", code=1
    )
    assert [one["fault"] for one in fault["forked"]["faults"]] == ["at 2.0: lidar_dead"]
    assert fault["others"][0]["forked"]["status"] == "success"


def test_another_version_of_a_mission_and_the_last_instant(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Both are those of the robot that is named."""
    path = tmp_path / "edited.yaml"
    path.write_text(DRIVES.replace("0.1", "0.2"), encoding="utf-8")
    found = forked(capsys, run, "--robot", "two", "--at", "0.5", "--mission", str(path))
    assert found["change"]["set"] == {"speed": 0.2}
    slow = tmp_path / "slow.yaml"
    slow.write_text("requirements: {goes: eventually speed > 0.15}\n", encoding="utf-8")
    words = ["--sweep-at", "--set", "speed=0.2", "--require", str(slow)]
    found = forked(capsys, run, "--robot", "two", *words)
    assert 0.9 < found["last"]["at_s"] < found["next"]["at_s"] < 1.2


def test_a_fork_is_a_recording_of_all_robots(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It names its fleet, and cannot be forked itself."""
    path = tmp_path / "forked.mcap"
    words = ["--robot", "two", "--at", "0.5", "--set", "speed=0.2", "--record", str(path)]
    assert forked(capsys, run, *words)["recording"] == str(path)
    assert main(["verify", str(path), "--json"]) == 0
    assert [one["robot"] for one in json.loads(capsys.readouterr().out)["robots"]] == ["one"]
    assert "it is itself a fork, of the run in run.mcap" in refused(capsys, str(path), "--at", "1")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--at", "1", "--set", "speed=0.2"], "say with --robot whose run is changed: one, two"),
        (
            ["--at", "1", "--robot", "tow"],
            "no mission of a robot 'tow' is in it (robots: one, two)",
        ),
        (["--at", "99", "--robot", "one"], "--at 99: the run ends at"),
        (["--at", "1", "--robot", "one", "--set", "speed=1"], "no variable 'speed'"),
        (["--at", "1", "--video", "x.mp4"], "--video does not apply to fleets: "),
    ],
)
def test_what_does_not_fit_is_refused(
    run: str, words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before anything runs."""
    assert message in refused(capsys, run, *words)


def test_the_robot_that_is_another_one_is_named_with_its_first_difference(
    run: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Although the other robot ends with it."""
    changes: dict[str, Any] = {"inputs": '{"speed": 0.2}'}
    path = with_facts(tmp_path / "other.mcap", changes, Path(run), "bt_mission /two/bt_mission")
    error = refused(capsys, str(path), "--at", "2")
    assert "two: run again, it is not the same up to 2.00 s" in error
    assert "they part at" in error
