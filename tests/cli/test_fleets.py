"""Fleets on the command line: reports, traces, options; the words are in transcripts/fleets.txt."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Any

import pytest
from py_trees.common import Status

from bt_mission.commands.completion import known
from bt_mission.executive.events.events import Event, NodeChanged
from bt_mission.sessions.session import MissionRun
from bt_mission.sessions.stage import Stage
from bt_mission.views.terminal.log_lines import LogLineView
from tests.support.command_line import CommandLine
from tests.support.thorough import sample

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


@pytest.fixture
def fleet(cli: CommandLine) -> CommandLine:
    """A folder with the fleets."""
    for name, text in (("two", FLEET), ("fails", FAILS), ("inputs", INPUTS)):
        cli.write(f"{name}.yaml", text)
    return cli


def test_programs_get_an_object_for_each_robot_and_a_sum(fleet: CommandLine) -> None:
    """The object of a robot is what `--json` says of one mission."""
    report = fleet.json("run two.yaml")
    assert (report["fleet"], report["status"], report["succeeded"]) == ("two", "success", 2)
    assert (report["world"], report["seed"], report["virtual_s"]) == ("dqn_stage1", 3, 2.05)
    assert (report["collisions_with_world"], report["collisions_among_robots"]) == (0, 0)
    first, second = report["robots"]
    assert (first["name"], first["mission"], first["virtual_s"]) == ("one", "turns", 1.95)
    assert [each["verdict"] for each in first["requirements"]] == ["holds"]
    assert (second["name"], second["robot"], second["seed"]) == ("two", "burger", 4)
    assert (second["collisions_with_world"], second["collisions_with_robots"]) == (0, {})
    assert second["leaves"][0]["name"] == "a while"


def test_one_mission_that_fails_fails_the_fleet(fleet: CommandLine) -> None:
    """The other one runs to its end."""
    report = fleet.json("run fails.yaml", 1)
    assert (report["status"], report["succeeded"]) == ("failure", 1)
    assert [each["status"] for each in report["robots"]] == ["success", "failure"]
    assert [each["virtual_s"] for each in report["robots"]] == [1.95, 0.65]


@pytest.mark.thorough
def test_two_runs_are_the_same_and_each_robot_has_its_trace(fleet: CommandLine) -> None:
    """`--trace it.jsonl` writes one file a robot, and overwrites none."""
    hashes = []
    for name in ("a", "b"):
        report = fleet.json(f"run two.yaml --trace {name}.jsonl")
        hashes.append([each["trace_sha256"] for each in report["robots"]])
    assert hashes[0] == hashes[1]
    for robot in ("one", "two"):
        assert Path(f"a.{robot}.jsonl").read_bytes() == Path(f"b.{robot}.jsonl").read_bytes()
    assert "a.one.jsonl exists" in fleet.refused("run two.yaml --trace a.jsonl")


def test_ctrl_c_halts_the_missions_of_all_robots(
    fleet: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With every goal confirmed; a mission that has ended stays as it is."""

    def interrupt(_: LogLineView, run: MissionRun, event: Event) -> None:
        match run.name, event:
            case "one", NodeChanged(node=node, status=Status.RUNNING) if node == TURN:
                signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(LogLineView, "kinds", (NodeChanged,))
    monkeypatch.setattr(LogLineView, "on_event", interrupt)
    report = fleet.json("run two.yaml", 130)
    assert report["status"] == "interrupted"
    assert [each["reason"] for each in report["robots"]] == ["interrupted by Ctrl-C"] * 2
    assert [each["goals_left_behind"] for each in report["robots"]] == [0, 0]


@pytest.mark.parametrize(
    ("given", "times"),
    sample(
        [
            ("", [3.05, 1.05]),
            ("time=0.5", [1.55, 0.55]),
            ("more=0.5", [2.55, 1.05]),
            ("two.time=0.5", [3.05, 0.55]),
            ("one.time=4 time=0.5", [5.05, 0.55]),
        ],
        3,
    ),
)
def test_inputs_are_set_for_every_mission_that_has_them_or_for_one_robot(
    fleet: CommandLine, given: str, times: list[float]
) -> None:
    """The value for one robot counts before that for all, and both before the file."""
    words = " ".join(f"--set {word}" for word in given.split())
    robots = fleet.json(f"run inputs.yaml {words}")["robots"]
    assert [each["virtual_s"] for each in robots] == times


def test_further_requirements_are_those_of_every_robot(fleet: CommandLine) -> None:
    """Each robot's own verdict is in its object."""
    fleet.write("r.yaml", "requirements: {is still: always speed < 0.01}\n")
    robots = fleet.json("run inputs.yaml --require r.yaml")["robots"]
    names = [[each["name"] for each in robot["requirements"]] for robot in robots]
    assert names == [["is still"]] * 2


def test_faults_are_in_the_report_and_the_trace_of_their_robots(fleet: CommandLine) -> None:
    """A fault without a robot is for each, on its own topics and conditions; two runs are equal."""
    fleet("run two.yaml --fault 'one: at 0.5: kill_server turn' --trace it.jsonl", 1)
    traces = [Path(f"it.{robot}.jsonl").read_text("utf-8") for robot in ("one", "two")]
    assert ['"event": "fault"' in trace for trace in traces] == [True, False]
    fault = "when speed < 1 and time >= 0.2: drop odom share 0.5 lasting 0.5"
    hashes = []
    for _ in range(2):
        robots = fleet.json(f"run two.yaml --fault '{fault}'")["robots"]
        expected = [
            {"fault": fault, "began": 0.2, "ended": 0.7, "why": "", "may_not_happen": False}
        ]
        assert [each["faults"] for each in robots] == [expected] * 2
        hashes.append([each["trace_sha256"] for each in robots])
    assert hashes[0] == hashes[1]


def test_a_fault_of_the_world_is_in_the_report_of_its_robot(fleet: CommandLine) -> None:
    """The box stands before the robot that the fault names."""
    fault = "two: at 0.5: spawn_box ahead 0.5 lasting 1"
    first, second = fleet.json(f"run two.yaml --fault '{fault}'")["robots"]
    assert (first["faults"], second["faults"][0]["ended"]) == ([], 1.5)


def test_names_of_fleets_and_their_inputs_are_completed(cli: CommandLine) -> None:
    """Inputs by their names, and by those of the robots before them."""
    cli.write("m.yaml", "mission: m\ninputs: {laps: 2}\n")
    cli.write("it.fleet.yaml", "fleet: it\nrobots: {one: {mission: m.yaml}, two: {}}\n")
    assert known("inputs", "bt-mission run it.fleet.yaml --set ") == ["laps=", "one.laps="]
    assert "fleets/two_wanderers.fleet.yaml" in cli.lines("completion --names runs")


def test_the_summary_comes_before_the_robots_are_taken_down(
    fleet: CommandLine, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 16 robots that takes seconds, in which a second Ctrl-C would lose the summary."""
    printed = []
    leave = Stage.__exit__

    def leaving(stage: Stage, *reason: Any) -> None:
        printed.append(capsys.readouterr().out)
        leave(stage, *reason)

    monkeypatch.setattr(Stage, "__exit__", leaving)
    fleet("run two.yaml --plain")
    assert "two: success (2 of 2 missions succeeded)" in printed[0]
    assert "collisions: 0 with the world, 0 among robots" in printed[0]
