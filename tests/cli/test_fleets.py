"""Fleets on the command line: run, check, schema, completion."""

from __future__ import annotations

import json
import signal
from pathlib import Path
from typing import Any

import pytest
from py_trees.common import Status

from bt_mission.cli import main
from bt_mission.cli.completion import known
from bt_mission.events.events import Event, NodeChanged
from bt_mission.sessions.session import Run
from bt_mission.sessions.stage import Stage
from bt_mission.views.terminal.speech import Speech

FLEET = """\
fleet: two
world: dqn_stage1
seed: 3
robots:
  one:
    mission:
      mission: turns
      requirements: {is slow: always speed < 1}
      tree:
        sequence:
          - turn: {angle: 90}
            name: turn
            timeout: 20
          - log: turned
    start: {x: -1}
  two:
    mission:
      mission: waits
      robot: burger
      tree: {wait: 2, name: a while}
    start: {x: 1, yaw: 90}
"""
FAILS = FLEET.replace("{wait: 2, name: a while}", "{turn: {angle: 90}, name: late, timeout: 0.5}")
TURN = 1
"""The index of that node in the tree of the first robot."""
VIOLATES = FLEET.replace("always speed < 1", "always yaw < 0.5")


@pytest.fixture
def fleet(tmp_path: Path) -> Any:
    """Write a fleet: ``fleet(text)`` gives its path."""

    def write(text: str = FLEET) -> str:
        path = tmp_path / "it.yaml"
        path.write_text(text, encoding="utf-8")
        return str(path)

    return write


def test_every_line_says_of_which_robot_it_tells(
    fleet: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """Instants are those of the runs; at the end there is a line for each robot, and a sum."""
    assert main(["run", fleet(), "--plain"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[:3] == [
        "two in dqn_stage1 (2 robots, seed 3)",
        "  one  turns (waffle, seed 3)",
        "  two  waits (burger, seed 4)",
    ]
    assert sorted(lines[3:8]) == [
        "     0.05 s  one  ▶ turn",
        "     0.05 s  two  ▶ a while",
        "     1.95 s  one    turned",
        "     1.95 s  one  ✓ turn",
        "     2.05 s  two  ✓ a while  0.0 s left",
    ]
    assert lines[8:11] == [
        "two: success (2 of 2 missions succeeded)",
        "  one  turns  1.95 s  0.00 m  0 collisions  success",
        "  two  waits  2.05 s  0.00 m  0 collisions  success",
    ]
    assert lines[12:] == [
        "  1 goal sent, 0 orphaned, 0.00 m driven",
        "  collisions: 0 with the world, 0 among robots",
    ]


def test_programs_get_an_object_for_each_robot_and_a_sum(
    fleet: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """What `--json` says of one mission stands in the object of each."""
    assert main(["run", fleet(), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["fleet"], found["status"], found["succeeded"]) == ("two", "success", 2)
    assert (found["world"], found["seed"], found["virtual_s"]) == ("dqn_stage1", 3, 2.05)
    assert (found["collisions_with_world"], found["collisions_among_robots"]) == (0, 0)
    one, two = found["robots"]
    assert (one["name"], one["mission"], one["virtual_s"]) == ("one", "turns", 1.95)
    assert [each["verdict"] for each in one["requirements"]] == ["holds"]
    assert (two["name"], two["robot"], two["seed"]) == ("two", "burger", 4)
    assert (two["collisions_with_world"], two["collisions_with_robots"]) == (0, {})
    assert two["leaves"][0]["name"] == "a while"


def test_one_mission_that_fails_fails_the_fleet(
    fleet: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """The other one goes on to its end."""
    assert main(["run", fleet(FAILS), "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert (found["status"], found["succeeded"]) == ("failure", 1)
    assert [one["status"] for one in found["robots"]] == ["success", "failure"]
    assert [one["virtual_s"] for one in found["robots"]] == [1.95, 0.65]


def test_a_requirement_that_is_violated_fails_the_fleet(
    fleet: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """It stands below the line of its robot."""
    assert main(["run", fleet(VIOLATES), "--plain"]) == 1
    lines = capsys.readouterr().out.splitlines()
    (at,) = (number for number, line in enumerate(lines) if line.startswith("  one  turns  1"))
    assert lines[at + 1].startswith("    requirement is slow: violated")


def test_two_runs_are_the_same_and_each_robot_has_its_trace(
    fleet: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`--trace it.jsonl` writes one file a robot, and overwrites none."""
    sums = []
    for name in ("a", "b"):
        trace = str(tmp_path / f"{name}.jsonl")
        assert main(["run", fleet(), "--json", "--trace", trace]) == 0
        found = json.loads(capsys.readouterr().out)
        sums.append([one["trace_sha256"] for one in found["robots"]])
    assert sums[0] == sums[1]
    for robot in ("one", "two"):
        assert (tmp_path / f"a.{robot}.jsonl").read_bytes() == (
            tmp_path / f"b.{robot}.jsonl"
        ).read_bytes()
    assert main(["run", fleet(), "--trace", str(tmp_path / "a.jsonl")]) == 2
    assert "a.one.jsonl exists" in capsys.readouterr().err


def test_ctrl_c_halts_the_missions_of_all_robots(
    fleet: Any, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With every goal confirmed; a mission that has ended stays as it is."""

    def interrupt(_: Speech, run: Run, event: Event) -> None:
        match run.name, event:
            case "one", NodeChanged(node=node, status=Status.RUNNING) if node == TURN:
                signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Speech, "on_event", interrupt)
    assert main(["run", fleet(), "--json"]) == 130
    found = json.loads(capsys.readouterr().out)
    assert found["status"] == "interrupted"
    assert [one["reason"] for one in found["robots"]] == ["interrupted by Ctrl-C"] * 2
    assert [one["goals_left_behind"] for one in found["robots"]] == [0, 0]


def test_check_says_of_whom_a_fleet_consists(
    fleet: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """Or what is wrong with it, with its place."""
    path = fleet()
    assert main(["check", path]) == 0
    assert capsys.readouterr().out == (
        f"{path}: fleet 'two' is valid (2 robots; one: turns, two: waits)\n"
    )
    assert main(["check", fleet(FLEET.replace("burger", "burgr"))]) == 2
    assert f"{path}:19:14: error: " in capsys.readouterr().err


INPUTS = """\
fleet: two
world: dqn_stage1
robots:
  one:
    mission: {mission: a, inputs: {time: 1, more: 1}, tree: {wait: $time + $more, name: it}}
    inputs: {time: 2}
    start: {x: -1}
  two:
    mission: {mission: b, inputs: {time: 1}, tree: {wait: $time}}
    start: {x: 1}
"""


@pytest.mark.parametrize(
    ("given", "times"),
    [
        ([], [3.05, 1.05]),
        (["time=0.5"], [1.55, 0.55]),
        (["more=0.5"], [2.55, 1.05]),
        (["two.time=0.5"], [3.05, 0.55]),
        (["one.time=4", "time=0.5"], [5.05, 0.55]),
    ],
)
def test_inputs_are_set_for_every_mission_that_has_them_or_for_one_robot(
    fleet: Any, capsys: pytest.CaptureFixture[str], given: list[str], times: list[float]
) -> None:
    """What is said of one robot counts before what is said of all, and both before the file."""
    words = [word for one in given for word in ("--set", one)]
    assert main(["run", fleet(INPUTS), "--json", *words]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [one["virtual_s"] for one in found["robots"]] == times


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("tim=1", "--set:1:1: error: no mission has an input 'tim' (their inputs: more, time)"),
        ("on.time=1", "--set:1:1: error: no robot 'on' (the fleet's robots: one, two)"),
        ("two.more=1", "--set:1:5: error: no input 'more' (the mission's inputs: time)"),
        ("two.time=x", "--set:1:10: error: input 'time' expects a number, got string 'x'"),
        ("time=x", "--set:1:6: error: input 'time' expects a number, got string 'x'"),
    ],
)
def test_a_value_that_no_robot_takes_is_an_error(
    fleet: Any, capsys: pytest.CaptureFixture[str], given: str, message: str
) -> None:
    """Once, at its place on the command line."""
    assert main(["check", fleet(INPUTS), "--set", given]) == 2
    said = capsys.readouterr().err
    assert said.count(message) == 1
    assert "1 error" in said


def test_further_requirements_are_those_of_every_robot(
    fleet: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A name that only one mission lacks is said with the robot."""
    file = tmp_path / "r.yaml"
    file.write_text("requirements: {is still: always speed < 0.01}\n", encoding="utf-8")
    assert main(["run", fleet(INPUTS), "--json", "--require", str(file)]) == 0
    robots = json.loads(capsys.readouterr().out)["robots"]
    assert [[each["name"] for each in one["requirements"]] for one in robots] == [["is still"]] * 2
    file.write_text("requirements: {ends: 'eventually succeeded(\"it\")'}\n", encoding="utf-8")
    assert main(["check", fleet(INPUTS), "--require", str(file)]) == 2
    assert "[two]" in capsys.readouterr().err
    file.write_text("requirements: {ends: eventually}\n", encoding="utf-8")
    assert main(["check", fleet(INPUTS), "--require", str(file)]) == 2
    assert "1 error\n" in capsys.readouterr().err


def test_a_fault_is_for_one_robot(
    fleet: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is said with the robot, and stands below its line and in its trace alone."""
    trace = tmp_path / "it.jsonl"
    fault = "one: at 0.5: kill_server turn"
    assert main(["run", fleet(), "--plain", "--fault", fault, "--trace", str(trace)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert "     0.50 s  one    fault 1 begins: kill_server action turn" in lines
    (at,) = (number for number, line in enumerate(lines) if line.startswith("  one  turns  "))
    assert "server lost: /one/turn" in lines[at]
    assert lines[at + 1] == "    fault at 0.5: kill_server turn: from 0.50 s on"
    assert lines[at + 2].startswith("  two  waits  2.05 s")
    assert '"event": "fault"' in (tmp_path / "it.one.jsonl").read_text(encoding="utf-8")
    assert '"event": "fault"' not in (tmp_path / "it.two.jsonl").read_text(encoding="utf-8")


def test_a_fault_without_a_robot_is_for_all(fleet: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """Each robot has it on its own topics and conditions; two runs are the same."""
    fault = "when speed < 1 and time >= 0.2: drop odom share 0.5 lasting 0.5"
    sums = []
    for _ in range(2):
        assert main(["run", fleet(), "--json", "--fault", fault]) == 0
        robots = json.loads(capsys.readouterr().out)["robots"]
        assert [each["faults"] for each in robots] == [
            [{"fault": fault, "began": 0.2, "ended": 0.7, "why": ""}]
        ] * 2
        sums.append([each["trace_sha256"] for each in robots])
    assert sums[0] == sums[1]


def test_a_fault_of_the_world_is_seen_by_both_robots(
    fleet: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """It stands before the robot that it names; another robot's fault cannot take it away."""
    box = ["--fault", "two: at 0.5: spawn_box ahead 0.5 lasting 1"]
    assert main(["run", fleet(), "--json", *box]) == 0
    one, two = json.loads(capsys.readouterr().out)["robots"]
    assert (one["faults"], two["faults"][0]["ended"]) == ([], 1.5)
    assert main(["run", fleet(), *box, "--fault", "one: at 1: remove_box"]) == 2
    said = capsys.readouterr().err
    assert (
        "--fault:1:6: error: remove_box: the obstacle is that of a fault of another robot" in said
    )


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("on: at 1: imu_dead", "--fault:1:1: error: no robot 'on' (the fleet's robots: one, two)"),
        ("one: at 1: imu_ded", "--fault:1:12: error: there is no fault 'imu_ded'"),
        ("one: at 1: drop scna", "--fault:1:17: error: there is no topic '/one/scna'"),
        ("one: when running('a while'): imu_dead", "--fault:1:11: error: no node is named"),
        ("when running('a while'): imu_dead", "[one]"),
        ("at 1: spawn_box ahead 1", "begin with its name, 'one: at 1: spawn_box ahead 1'"),
        ("one:", "--fault:1:5: error: expected a fault such as 'at 5.0: drop scan lasting 2'"),
    ],
)
def test_a_fault_that_no_robot_can_have_is_an_error(
    fleet: Any, capsys: pytest.CaptureFixture[str], fault: str, message: str
) -> None:
    """At its place, before anything moves."""
    assert main(["run", fleet(), "--fault", fault]) == 2
    said = capsys.readouterr()
    assert message in said.err
    assert said.err.count(": error: ") == 1
    assert said.out == ""


def test_inputs_of_a_fleet_are_completed(tmp_path: Path) -> None:
    """By their names, and by those of the robots before them."""
    (tmp_path / "m.yaml").write_text("mission: m\ninputs: {laps: 2}\n", encoding="utf-8")
    path = tmp_path / "it.fleet.yaml"
    path.write_text("fleet: it\nrobots: {one: {mission: m.yaml}, two: {}}\n", encoding="utf-8")
    assert known("inputs", f"bt-mission run {path} --set ") == ["laps=", "one.laps="]


def test_schema_and_completion_know_fleets(capsys: pytest.CaptureFixture[str]) -> None:
    """As they know scenarios."""
    assert main(["schema", "fleet"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "bt-mission fleet"
    assert main(["completion", "--names", "runs"]) == 0
    assert "fleets/two_wanderers.fleet.yaml" in capsys.readouterr().out.splitlines()


def test_the_summary_comes_before_the_robots_are_taken_down(
    fleet: Any, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 16 robots that takes seconds, in which a second Ctrl-C would leave without a word."""
    said = []
    leave = Stage.__exit__

    def leaving(stage: Stage, *reason: Any) -> None:
        said.append(capsys.readouterr().out)
        leave(stage, *reason)

    monkeypatch.setattr(Stage, "__exit__", leaving)
    assert main(["run", fleet(), "--plain"]) == 0
    assert "two: success (2 of 2 missions succeeded)" in said[0]
    assert "collisions: 0 with the world, 0 among robots" in said[0]
