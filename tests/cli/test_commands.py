"""The command line says what is wrong, where, and ends with the right exit code."""

from __future__ import annotations

import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from bt_mission.cli import main

WAIT = "mission: short\ntree: {wait: 0.5}\n"


@pytest.fixture
def mission(tmp_path: Path) -> Any:
    """Write a mission file: ``mission(text)`` gives its path."""

    def write(text: str) -> str:
        path = tmp_path / "mission.yaml"
        path.write_text(text, encoding="utf-8")
        return str(path)

    return write


def test_a_successful_run_exits_with_0_and_says_what_it_came_to(
    mission: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """Plain lines, since the output is no terminal; the last lines are the summary."""
    assert main(["run", mission(WAIT)]) == 0
    out, err = capsys.readouterr()
    lines = out.splitlines()
    assert lines[0] == "short (waffle, seed 0)"
    assert lines[1:4] == [
        "     0.05 s  ▶ wait",
        "     0.55 s  ✓ wait  0.0 s left",
        "short: success",
    ]
    assert lines[-1] == "  0 goals sent, 0 orphaned, 0.00 m driven, 0 collisions"
    assert err == ""


def test_json_is_one_object_with_every_field(
    mission: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing else goes to standard output."""
    assert main(["run", mission(WAIT), "--json", "--seed", "4"]) == 0
    report = json.loads(capsys.readouterr().out)
    expected = {
        "mission": "short",
        "status": "success",
        "reason": "",
        "seed": 4,
        "virtual_s": 0.55,
        "ticks": 11,
        "goals_sent": 0,
        "goals_left_behind": 0,
        "collisions": 0,
    }
    assert expected.items() <= report.items()
    assert {"wall_s", "real_time_factor", "distance_travelled_m"} <= report.keys()
    assert len(report["trace_sha256"]) == 64


def test_a_failed_mission_exits_with_1(mission: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """A goal that the server rejects, for one; its reason stands in the server's log."""
    text = (
        "mission: m\ninputs: {speed: 9}\ntree:\n  sequence:\n    - set: {speed_now: speed * 11}\n"
        "    - turn: {angle: 90, angular_velocity: $speed_now}\n      timeout: 9\n"
    )
    assert main(["run", mission(text)]) == 1
    assert "m: failure: 'turn' rejected" in capsys.readouterr().out


def test_a_violated_requirement_exits_with_1(
    mission: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where the mission itself succeeds; it is said at once, and at the end."""
    file = tmp_path / "extra.yaml"
    file.write_text("requirements:\n  is quick: always speed > 1\n  is slow: always speed < 1\n")
    assert main(["run", mission(WAIT), "--require", str(file)]) == 1
    said = capsys.readouterr().out
    assert said.count("requirement is quick: violated by 1 m/s at 0.05 s") == 2
    assert "requirement is slow: holds by 1 m/s" in said
    assert main(["run", mission(WAIT), "--require", str(file), "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert [one["verdict"] for one in told["requirements"]] == ["violated", "holds"]


@pytest.mark.parametrize("command", ["check", "run"])
def test_bad_input_exits_with_2_and_points_at_it(
    mission: Any, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    """File, line, column, the line, a caret, a hint; nothing has moved."""
    path = mission("mission: m\ntree:\n  turn: {angel: 90}\n  timeout: 9\n")
    assert main([command, path]) == 2
    err = capsys.readouterr().err
    assert f"{path}:3:10: error:" in err
    assert "    turn: {angel: 90}" in err
    assert "did you mean 'angle'?" in err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--world", "atlantis"], "atlantis"),
        (["--robot", "hexapod"], "hexapod"),
        (["--set", "speed=1"], "speed"),
    ],
)
def test_bad_overrides_exit_with_2_and_are_named(
    mission: Any, capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    """Options are checked as the file is."""
    assert main(["run", mission(WAIT), *arguments]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "x.yaml", "--set", "no-equals"],
        ["run", "x.yaml", "--speed", "0"],
        ["run", "x.yaml", "--speed", "nan"],
        ["run", "x.yaml", "--seed", "many"],
        ["run", "x.yaml", "--seed=-1"],
        ["run"],
        ["fly"],
        [],
    ],
)
def test_wrong_options_exit_with_2(arguments: list[str]) -> None:
    """As argparse has it; the message says what was expected."""
    with pytest.raises(SystemExit) as exit_:
        main(arguments)
    assert exit_.value.code == 2


def test_a_missing_file_is_bad_input(capsys: pytest.CaptureFixture[str]) -> None:
    """With the name of the file, and no traceback."""
    assert main(["check", "no/such/mission.yaml"]) == 2
    assert "no/such/mission.yaml" in capsys.readouterr().err


def test_a_shipped_mission_is_found_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """From any folder; an unknown name is answered with those that are known."""
    monkeypatch.chdir(tmp_path)
    assert main(["check", "square"]) == 0
    assert "mission 'square' is valid" in capsys.readouterr().out
    assert main(["check", "squares"]) == 2
    err = capsys.readouterr().err
    assert "no such mission (known: explore" in err
    assert "did you mean 'square'?" in err


def test_scenarios_and_fleets_are_found_by_their_names_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As `missions copy` takes them; a mission comes first, and one that is near is offered."""
    monkeypatch.chdir(tmp_path)
    assert main(["check", "two_wanderers"]) == 0
    assert "fleet 'two wanderers' is valid" in capsys.readouterr().out
    assert main(["check", "scan_lost"]) == 0
    assert "scenario " in capsys.readouterr().out
    assert main(["check", "patrol"]) == 0
    assert "mission 'patrol' is valid" in capsys.readouterr().out
    assert main(["check", "two_wanderer"]) == 2
    assert "did you mean 'two_wanderers'?" in capsys.readouterr().err


def test_a_folder_hides_no_mission_and_that_of_a_project_is_to_be_entered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Who has just made a project is told so."""
    monkeypatch.chdir(tmp_path)
    Path("square").mkdir()
    assert main(["check", "square"]) == 0
    assert main(["new", "walker"]) == 0
    assert main(["check", "walker"]) == 2
    said = "walker: error: expected a mission, got a folder; commands are called in it: cd walker"
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("domain", ["abc", "999", "-1"])
def test_a_domain_that_is_none_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], domain: str
) -> None:
    """Before DDS says so in its own words."""
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    assert main(["run", "square"]) == 2
    assert f"ROS_DOMAIN_ID: expected 0 to 232, got '{domain}'" in capsys.readouterr().err


def test_an_unexpected_error_is_a_line_and_no_traceback(
    mission: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With what to do next."""

    def explode(*_: object, **__: object) -> None:
        raise RuntimeError("something broke")

    monkeypatch.setattr("bt_mission.sessions.stage.Stage", explode)
    assert main(["run", mission(WAIT)]) == 1
    err = capsys.readouterr().err
    assert err.startswith("RuntimeError: something broke\n`bt-mission doctor` checks")


def test_a_faulty_world_is_found_by_check(
    mission: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """And not only when it is run."""
    world = tmp_path / "world.yaml"
    world.write_text("name: w\nsize: [4, 4]\nwals: []\n", encoding="utf-8")
    assert main(["check", mission(WAIT), "--world", str(world)]) == 2
    assert f"{world}:3:1: error:" in capsys.readouterr().err


def test_a_middleware_that_is_absent_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Rclpy would end the process while it is imported."""
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_pigeon_cpp")
    assert main(["run", "square"]) == 2
    assert "RMW_IMPLEMENTATION=rmw_pigeon_cpp cannot be loaded" in capsys.readouterr().err


def test_check_says_that_a_mission_is_sound(
    mission: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """And how large it is."""
    path = mission(WAIT)
    assert main(["check", path]) == 0
    assert capsys.readouterr().out == f"{path}: mission 'short' is valid (1 node)\n"


def test_check_speaks_to_programs(mission: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """A JSON list, empty where nothing is to be said; the exit code is that of the words."""
    assert main(["check", "--json", mission(WAIT)]) == 0
    assert json.loads(capsys.readouterr().out) == []
    path = mission("mission: short\ntree: {wate: 1}\n")
    assert main(["check", "--json", path]) == 2
    (fault,) = json.loads(capsys.readouterr().out)
    assert (fault["file"], fault["line"], fault["column"]) == (path, 2, 8)
    assert (fault["severity"], fault["hint"]) == ("error", "did you mean 'wait'?")


def test_the_schema_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    """As JSON, to be put into a file."""
    assert main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "bt-mission"


def test_the_trace_can_be_written_to_a_file(
    mission: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One JSON object a line, from the version of the format to the end of the mission."""
    trace = tmp_path / "trace.jsonl"
    assert main(["run", mission(WAIT), "--trace", str(trace)]) == 0
    events = [json.loads(line) for line in trace.read_text(encoding="utf-8").splitlines()]
    assert events[0] == {"trace_version": 3}
    assert events[1]["event"] == "start"
    assert [e["status"] for e in events if e.get("event") == "mission"] == ["success"]
    capsys.readouterr()


def test_a_trace_that_cannot_be_written_is_bad_input(
    mission: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before the mission starts, with the path and the reason."""
    assert main(["run", mission(WAIT), "--trace", str(tmp_path)]) == 2
    assert "is a folder; name a file" in capsys.readouterr().err


def test_help_teaches(capsys: pytest.CaptureFixture[str]) -> None:
    """Examples and exit codes stand in it."""
    with pytest.raises(SystemExit) as exit_:
        main(["--help"])
    assert exit_.value.code == 0
    out = capsys.readouterr().out
    assert "bt-mission run explore" in out
    assert "130 interrupted" in out


def test_several_missions_are_checked_at_once(mission, capsys):
    """Each tells its faults, and the exit code is the worst."""
    assert main(["check", "square", "patrol"]) == 0
    assert capsys.readouterr().out.endswith("2 of 2 missions are valid\n")
    assert main(["check", mission("mission: x\ntree: {turn: {angel: 1}}\n"), "square"]) == 2
    said = capsys.readouterr()
    assert "no field 'angel'" in said.err
    assert said.out.endswith("1 of 2 missions are valid\n")
    assert main(["check", "--json", "square", "patrol"]) == 0
    assert capsys.readouterr().out == "[]\n"


def test_it_says_its_version(capsys):
    """And leaves with 0."""
    with pytest.raises(SystemExit) as left:
        main(["--version"])
    assert left.value.code == 0
    assert capsys.readouterr().out == f"bt-mission {version('bt-mission')}\n"
