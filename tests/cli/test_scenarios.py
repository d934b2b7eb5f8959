"""Scenarios on the command line: run, check, schema, completion."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from bt_mission.cli import main
from tests.support.project import SCENARIOS

SCENARIO = """\
scenario: it turns
mission:
  mission: turns
  world: empty_arena
  tree: {turn: {angle: 90}, name: turn, timeout: 20}
faults:
  - at 0.5: kill_server turn
requirements:
  is slow: always speed < 1
"""
FAILS = "expect: {outcome: failure, failed: turn, orphaned_goals: 1}\n"


@pytest.fixture
def scenario(tmp_path: Path) -> Any:
    """Write a scenario: ``scenario(text)`` gives its path."""

    def write(text: str) -> str:
        path = tmp_path / "it.yaml"
        path.write_text(SCENARIO + text, encoding="utf-8")
        return str(path)

    return write


def test_a_run_exits_with_0_where_what_must_come_out_does(
    scenario: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where that is a failure of the mission."""
    assert main(["run", scenario(FAILS)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "     0.50 s    fault 1 begins: kill_server action turn" in lines
    assert lines[-1] == "scenario it turns: passed (expected failure)"


def test_a_run_exits_with_1_where_something_else_comes_out(
    scenario: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each difference has its place in the file."""
    path = scenario("expect: {outcome: success, orphaned_goals: 1}\n")
    assert main(["run", path]) == 1
    out = capsys.readouterr().out
    assert f"{path}:10:19: error: expected success, got failure: " in out
    assert out.endswith("scenario it turns: failed\n")


def test_json_tells_what_came_out(scenario: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """Beside the report of the run, with its faults and requirements."""
    assert main(["run", scenario(FAILS), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["scenario"] == {"name": "it turns", "passed": True, "differences": []}
    assert told["faults"][0]["fault"] == "at 0.5: kill_server turn"
    assert told["requirements"][0]["verdict"] == "holds"


def test_options_change_a_scenario_and_add_to_it(
    scenario: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As they do with a mission."""
    more = tmp_path / "more.yaml"
    more.write_text("requirements:\n  is fast: always speed > 1\n", encoding="utf-8")
    options = ["--seed", "4", "--fault", "at 0.2: imu_dead", "--require", str(more), "--json"]
    assert main(["run", scenario(FAILS), *options]) == 1
    told = json.loads(capsys.readouterr().out)
    assert told["seed"] == 4
    assert len(told["faults"]) == 2
    assert "requirement is fast: violated" in told["scenario"]["differences"][0]


@pytest.mark.parametrize("command", ["run", "check"])
def test_bad_input_exits_with_2_and_points_at_it(
    scenario: Any, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    """File, line, column, the line, a caret, a hint."""
    path = scenario("expct: {outcome: failure}\n")
    assert main([command, path]) == 2
    err = capsys.readouterr().err
    assert f"{path}:10:1: error: unknown key 'expct'" in err
    assert "did you mean 'expect'?" in err


def test_check_finds_a_fault_on_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """On the stage of the scenario, where nothing moves; also for programs."""
    path = tmp_path / "it.yaml"
    path.write_text(SCENARIO.replace("kill_server turn", "drop scna"), encoding="utf-8")
    assert main(["check", str(path)]) == 2
    assert f"{path}:7:18: error: there is no topic '/scna'" in capsys.readouterr().err
    assert main(["check", str(path), "--json"]) == 2
    (fault,) = json.loads(capsys.readouterr().out)
    assert (fault["line"], fault["column"]) == (7, 18)


@pytest.mark.parametrize("command", ["tree", "convert"])
def test_commands_for_missions_say_what_takes_a_scenario(
    scenario: Any, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    """In place of what is wrong with it as a mission."""
    assert main([command, scenario("")]) == 2
    err = capsys.readouterr().err
    assert "expected a mission, got a scenario; 'bt-mission run'" in err
    assert err.count("error:") == 1


def test_a_start_in_a_wall_hides_no_other_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It has its place in a check and in a run; the files after it are checked."""
    path, sound = tmp_path / "in_a_wall.yaml", tmp_path / "sound.yaml"
    path.write_text("scenario: s\nmission: explore\nstart: {x: 2.35, y: 0}\n", encoding="utf-8")
    sound.write_text("mission: m\nworld: empty_arena\ntree: {wait: 1}\n", encoding="utf-8")
    assert main(["check", str(path), str(sound)]) == 2
    out, err = capsys.readouterr()
    message = "a waffle does not fit at the spawn (2.35, 0, 0 deg): it touches 'east wall'"
    line = f"{path}:3:8: error: world dqn_stage4: {message}; move the spawn, or make room"
    assert line in err.splitlines()
    assert out.splitlines()[1:] == ["1 of 2 files are valid"]
    assert f"{sound}: mission 'm' is valid" in out
    assert main(["run", str(path)]) == 2
    assert line in capsys.readouterr().err.splitlines()
    assert main(["check", "--json", str(path), str(sound)]) == 2
    (fault,) = json.loads(capsys.readouterr().out)
    assert (fault["file"], fault["line"], fault["column"]) == (str(path), 3, 8)
    assert main(["check", "--against", "--json", str(path), str(sound)]) == 2
    (fault,) = json.loads(capsys.readouterr().out)
    assert "does not apply to scenario files" in fault["message"]


def test_check_tells_what_is_in_a_scenario(
    scenario: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """Beside missions, too."""
    assert main(["check", scenario(FAILS), "square"]) == 0
    out = capsys.readouterr().out
    assert "scenario 'it turns' is valid (mission 'turns', 1 fault, 1 requirement)" in out
    assert "2 of 2 files are valid" in out


def test_the_schema_of_scenarios_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    """Beside that of missions."""
    assert main(["schema", "scenario"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "bt-mission scenario"


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.name)
def test_shipped_scenarios_are_found_by_their_names(
    path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: Any, tmp_path: Path
) -> None:
    """From any folder."""
    monkeypatch.chdir(tmp_path)
    assert main(["check", f"scenarios/{path.name}"]) == 0
    assert "is valid" in capsys.readouterr().out
