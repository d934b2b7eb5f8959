"""Exit codes of the commands, and what they print for programs; the words are in transcripts/."""

import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from sim.views import window
from sim.views.window import DISPLAYS
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
    kinds = [event.get("event") for event in events if event.get("event") != "pose"]
    assert kinds == [None, "start", "status", "status", "mission"]
    assert [e["status"] for e in events if e.get("event") == "mission"] == ["success"]


def test_help_and_version_exit_with_0(cli: CommandLine) -> None:
    """The help has examples and exit codes."""
    out = cli("--help")
    assert "bt-mission run explore" in out
    assert "130 interrupted" in out
    assert cli("--version") == f"bt-mission {version('bt-mission')}\n"


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
    for command in ("check", "check --import-python", "run", "run --attach"):
        cli.refused(f"{command} --no-python m.yaml")
    assert not Path("ran").exists()
    assert "no attribute 'tmies' on Leaf" in cli.refused("check --import-python m.yaml")
    assert Path("ran").exists()


def test_check_constructs_python_leaves_that_it_imports(cli: CommandLine) -> None:
    """What the constructor raises has its place in the mission, and in the file."""
    cli.write(
        "leaf.py",
        "from py_trees.behaviour import Behaviour\n\nclass Leaf(Behaviour):\n"
        "    def __init__(self, name):\n        raise OSError('no camera')\n\n"
        "    def update(self):\n        pass\n",
    )
    cli.write("m.yaml", "mission: m\ntree: {python: 'leaf.py:Leaf'}\n")
    cli("check m.yaml")
    raised = "Leaf('Leaf') raised OSError: no camera (leaf.py:5)"
    assert f"m.yaml:2:16: error: {raised}" in cli.refused("check --import-python m.yaml")


def test_without_a_display_no_simulation_begins(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line says why, and what to do instead; for `run`, the catalogue of errors has it."""
    for name in DISPLAYS:
        monkeypatch.delenv(name, raising=False)
    error = cli.refused("sim --view")
    assert error.startswith("--view: there is no display here")
    assert error.count("\n") == 1


def test_a_run_is_shown_in_a_window_in_real_time(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After each tick, until it is over."""
    seen: list[str] = []

    class Shown:
        def __init__(self, physics: Any) -> None:
            seen.append("opened")

        def look(self) -> None:
            seen.append("look")

        def close(self) -> None:
            seen.append("closed")

    monkeypatch.setattr(window, "check_display", lambda: None)
    monkeypatch.setattr(window, "Window", Shown)
    report = cli.json(f"run {cli.write('m.yaml', WAIT)} --view")
    assert (seen[0], seen[-1], seen.count("look")) == ("opened", "closed", 11)
    assert report["real_time_factor"] <= 1.1
