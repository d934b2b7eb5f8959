"""Exit codes of the commands, and what they print for programs; the words are in transcripts/."""

import json
from importlib.metadata import version
from pathlib import Path

import pytest

from tests.support.command_line import CommandLine

WAIT = "mission: short\ntree: {wait: 0.5}\n"


def test_json_is_one_object_with_every_field(cli: CommandLine) -> None:
    """Nothing else goes to standard output."""
    report = cli.json(f"run {cli.write('m.yaml', WAIT)} --seed 4")
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


def test_a_failed_mission_exits_with_1(cli: CommandLine) -> None:
    """Here the server rejects a goal, and says why in its log."""
    cli.write(
        "m.yaml",
        "mission: m\ninputs: {speed: 9}\ntree:\n  sequence:\n    - set: {speed_now: speed * 11}\n"
        "    - turn: {angle: 90, angular_velocity: $speed_now}\n      timeout: 9\n",
    )
    assert "m: failure: 'turn' rejected" in cli("run m.yaml", 1)


def test_a_violated_requirement_exits_with_1(cli: CommandLine) -> None:
    """The violation is printed when it happens and at the end, though the mission succeeds."""
    cli.write("m.yaml", WAIT)
    cli.write(
        "r.yaml", "requirements:\n  is quick: always speed > 1\n  is slow: always speed < 1\n"
    )
    out = cli("run m.yaml --require r.yaml", 1)
    assert out.count("requirement is quick: violated by 1 m/s at 0.05 s") == 2
    assert "requirement is slow: holds by 1 m/s" in out
    report = cli.json("run m.yaml --require r.yaml", 1)
    assert [each["verdict"] for each in report["requirements"]] == ["violated", "holds"]


@pytest.mark.parametrize(
    ("command", "near"),
    [("check squares", "square"), ("check two_wanderer", "two_wanderers"), ("convert squares", "")],
)
def test_an_unknown_name_is_answered_with_those_that_are_known(
    cli: CommandLine, command: str, near: str
) -> None:
    """The near ones are suggested."""
    error = cli.refused(command)
    assert "no such mission (known: explore" in error
    assert f"did you mean '{near or 'square'}'?" in error


def test_a_folder_hides_no_mission_and_that_of_a_project_is_to_be_entered(
    cli: CommandLine,
) -> None:
    """An error in a new project says so."""
    Path("square").mkdir()
    cli("check square")
    cli("new walker")
    expected = "walker: error: expected a mission, got a folder; run the command in it: cd walk"
    assert expected in cli.refused("check walker")


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("ROS_DOMAIN_ID", "abc", "ROS_DOMAIN_ID: expected 0 to 232, got 'abc'"),
        ("ROS_DOMAIN_ID", "999", "ROS_DOMAIN_ID: expected 0 to 232, got '999'"),
        ("ROS_DOMAIN_ID", "-1", "ROS_DOMAIN_ID: expected 0 to 232, got '-1'"),
        ("RMW_IMPLEMENTATION", "rmw_pigeon_cpp", "=rmw_pigeon_cpp cannot be loaded"),
    ],
)
def test_an_environment_that_ros_cannot_use_is_named(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch, name: str, value: str, expected: str
) -> None:
    """Importing rclpy would end the process, and DDS would fail in its own words."""
    monkeypatch.setenv(name, value)
    assert expected in cli.refused("run square")


def test_an_unexpected_error_is_a_line_and_no_traceback(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With what to do next."""

    def explode(*_: object, **__: object) -> None:
        raise RuntimeError("something broke")

    monkeypatch.setattr("bt_mission.sessions.stage.Stage", explode)
    cli(f"run {cli.write('m.yaml', WAIT)}", 1)
    assert cli.err.startswith("RuntimeError: something broke\n`bt-mission doctor` checks")


@pytest.mark.parametrize(
    ("command", "title"),
    [
        ("schema", "bt-mission"),
        ("schema scenario", "bt-mission scenario"),
        ("schema fleet", "bt-mission fleet"),
    ],
)
def test_schemas_are_printed(cli: CommandLine, command: str, title: str) -> None:
    """As JSON, to be put into a file."""
    assert json.loads(cli(command))["title"] == title


def test_the_trace_can_be_written_to_a_file(cli: CommandLine) -> None:
    """One JSON object a line, from the version of the format to the end of the mission."""
    cli(f"run {cli.write('m.yaml', WAIT)} --trace t.jsonl")
    events = [json.loads(line) for line in Path("t.jsonl").read_text("utf-8").splitlines()]
    assert events[0] == {"trace_version": 3}
    assert events[1]["event"] == "start"
    assert [e["status"] for e in events if e.get("event") == "mission"] == ["success"]


def test_check_imports_python_leaves_where_told_to(cli: CommandLine) -> None:
    """Otherwise their code does not run; imported, their attributes are known."""
    cli.write(
        "leaf.py",
        "import pathlib\n\nfrom py_trees.behaviour import Behaviour\n\n"
        'pathlib.Path(__file__).with_name("ran").touch()\n\n\n'
        "class Leaf(Behaviour):\n    times: int = 1\n",
    )
    cli.write("m.yaml", "mission: m\ntree:\n  python: leaf.py:Leaf\n  inputs: {tmies: 2}\n")
    cli("check m.yaml")
    assert "--import-python" in cli.err
    cli.write("good.yaml", "mission: m\ntree:\n  python: leaf.py:Leaf\n")
    cli.write("a.scenario.yaml", "scenario: a\nmission: good.yaml\nsimulator: leaf.py:Leaf\n")
    cli("check a.scenario.yaml")
    assert cli.err.count("was not imported") == 2
    for command in ("check", "check --import-python", "run", "run --attach"):
        assert "is refused; --no-python" in cli.refused(f"{command} --no-python m.yaml")
    assert not Path("ran").exists()
    assert "no attribute 'tmies' on Leaf" in cli.refused("check --import-python m.yaml")
    assert Path("ran").exists()


def test_help_and_version_exit_with_0(cli: CommandLine) -> None:
    """The help has examples and exit codes."""
    out = cli("--help")
    assert "bt-mission run explore" in out
    assert "130 interrupted" in out
    assert cli("--version") == f"bt-mission {version('bt-mission')}\n"
