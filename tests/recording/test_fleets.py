"""One recording holds several robots: each is read, replayed, reported and verified by itself."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from bt_mission.cli import main
from bt_mission.recording.facts import FACTS, note_of
from bt_mission.recording.file import McapFile
from bt_mission.recording.reader import read_run
from bt_mission.recording.reading import RecordedFile, RecordingError
from bt_mission.recording.replay.player import Player
from bt_mission.recording.replay.timeline import read_timeline
from bt_mission.recording.robots import recorded_robots
from bt_mission.recording.verification import RecordedRequirements
from tests.support.recordings import write_messages
from tests.support.report_pages import data_of

FLEET = """\
fleet: two
world: dqn_stage1
robots:
  one:
    mission:
      mission: drives
      seed: 5
      requirements: {comes forth: eventually distance > 0.3, is fast: always speed > 1}
      tree:
        sequence:
          - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.4}
            name: drive
            timeout: 2
            cancel_when: current_distance_travelled > 0.32
            on_cancel: success
          - log: there
    start: {x: -1}
    seed: 5
  two:
    mission:
      mission: turns
      robot: burger
      requirements: {has room: always clearance > 0.1}
      tree: {turn: {angle: 90}, name: turn, timeout: 20}
    start: {x: 1, yaw: 90}
    seed: 5
"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """A recording of a fleet, and what `--json` said of its run."""
    folder = tmp_path_factory.mktemp("fleet")
    (folder / "two.yaml").write_text(FLEET, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        lines: list[str] = []
        patch.setattr("builtins.print", lambda text="", **_: lines.append(str(text)))
        main(["run", str(folder / "two.yaml"), "--json", "--record", str(folder / "two.mcap")])
    return folder / "two.mcap", json.loads(lines[-1])


def test_the_robots_of_a_recording_are_known_at_its_beginning(recorded: Any) -> None:
    """In the order of the fleet; one that is not there is named with those that are."""
    path, _ = recorded
    assert recorded_robots(path) == ["one", "two"]
    with pytest.raises(RecordingError, match=r"contains no mission of a robot 'tow' \(robots: one"):
        read_run(path, "tow")


def test_topics_of_all_robots_are_in_it(recorded: Any) -> None:
    """Those of their sensors, and those of their executives."""
    path, _ = recorded
    topics = {channel.topic for channel, *_ in RecordedFile(path).messages()}
    for robot in ("one", "two"):
        for topic in ("scan", "odom", "cmd_vel", "bt_mission/tree", "bt_mission/trace"):
            assert f"/{robot}/{topic}" in topics


@pytest.mark.parametrize("number", [0, 1])
def test_a_run_is_that_of_its_robot(recorded: Any, number: int) -> None:
    """Tree, goals, log, trace, path and summary are; nothing of the other one is in it."""
    path, output = recorded
    robot = ("one", "two")[number]
    run = read_run(path, robot)
    assert run.mission == output["robots"][number]["mission"]
    assert run.node == f"/{robot}/bt_mission"
    assert run.summary["trace_sha256"] == output["robots"][number]["trace_sha256"]
    assert {goal.action.split("/")[1] for goal in run.goals} == {robot}
    assert [goal.status for goal in run.goals] == [("canceled", "succeeded")[number]]
    assert {line.name for line in run.log if "bt_mission" in line.name} == {f"{robot}.bt_mission"}
    assert float(run.truth.x[0]) == pytest.approx((-1.0, 1.0)[number], abs=0.01)
    assert run.facts["seed"] == "5"


def test_without_a_choice_the_first_is_read(recorded: Any) -> None:
    """As the first executive of a file always was."""
    path, _ = recorded
    assert read_run(path).mission == "drives"


def test_a_replay_has_all_robots_on_the_map(recorded: Any) -> None:
    """The tree is that of the chosen one; the others are where they truly were."""
    path, _ = recorded
    player = Player(read_timeline(path, "two"), at_s=1.8)
    assert player.timeline.robots == ("one", "two")
    mission = player.mission
    assert mission.tree is not None
    assert mission.tree.mission == "turns"
    assert mission.robot.pose is not None
    assert mission.robot.pose.x == pytest.approx(1.0, abs=0.05)
    assert list(mission.robot.others) == ["one"]
    assert -1.0 < mission.robot.others["one"].x < -0.6


@pytest.mark.parametrize("number", [0, 1])
def test_verdicts_and_margins_are_those_of_the_run(recorded: Any, number: int) -> None:
    """Instant by instant, from the signals of that robot."""
    path, output = recorded
    result = RecordedRequirements(path, robot=("one", "two")[number])
    results = result.verify(result.own()).results
    reports = output["robots"][number]["requirements"]
    assert [(judged.name, judged.verdict, judged.margin, judged.at) for judged in results] == [
        (report["name"], report["verdict"], report["margin"], report["at"]) for report in reports
    ]


def test_verify_tells_of_every_robot(recorded: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """The exit code is the worst."""
    path, _ = recorded
    assert main(["verify", str(path)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert [line.rpartition(",")[0] for line in lines if line.startswith(str(path))] == [
        f"{path}: one: drives",
        f"{path}: two: turns",
    ]
    assert main(["verify", str(path), "--robot", "two", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["mission"] == "turns"
    assert main(["verify", str(path), "--json"]) == 1
    assert [robot["robot"] for robot in json.loads(capsys.readouterr().out)["robots"]] == [
        "one",
        "two",
    ]


def test_a_report_is_one_page_of_all_robots(
    recorded: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each with its data; with --robot, of the chosen one only."""
    path, _ = recorded
    page = tmp_path / "it.html"
    assert main(["report", str(path), "-o", str(page)]) == 0
    assert capsys.readouterr().out.splitlines() == [str(page)]
    runs = data_of(page)
    missions = {robot: data["messages"][0]["tree"]["mission"] for robot, data in runs.items()}
    assert missions == {"one": "drives", "two": "turns"}
    assert "two" in runs["one"]["others"]
    assert main(["report", str(path), "-o", str(page), "--force", "--robot", "two"]) == 0
    assert list(data_of(page)) == ["two"]


def test_replay_in_lines_is_the_trace_of_the_chosen_robot(
    recorded: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without a choice it says which others there are."""
    path, _ = recorded
    assert main(["replay", str(path), "--plain", "--robot", "two"]) == 0
    shown = capsys.readouterr()
    assert "/two/turn" in shown.out
    assert "/one/" not in shown.out
    assert shown.err == ""
    assert main(["replay", str(path), "--once"]) == 0
    assert capsys.readouterr().err == "shown: one; with --robot NAME: two\n"


@pytest.mark.parametrize(
    ("node", "mission", "state"),
    [("/one/bt_mission", "drives", "success"), ("/two/bt_mission", "turns", "success")],
)
def test_of_several_executives_in_a_graph_the_recorded_one_is_read(
    recorded: Any, tmp_path: Path, node: str, mission: str, state: str
) -> None:
    """As where one of them was attached: the others are not missions of this recording."""
    path, _ = recorded
    whole = RecordedFile(path)
    messages = list(whole.messages())
    file = McapFile(tmp_path / "one.mcap", "test")
    file.note(FACTS, whole.notes[note_of(FACTS, node)])
    run = read_run(write_messages(file, messages))
    assert (run.node, run.mission, run.status) == (node, mission, state)
    player = Player(read_timeline(file.path))
    player.go(player.duration_s)
    assert player.mission.tree is not None
    assert (player.mission.tree.mission, player.timeline.robots) == (mission, (node.split("/")[1],))
    assert RecordedRequirements(file.path).mission == mission
