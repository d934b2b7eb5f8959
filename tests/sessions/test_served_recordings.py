"""Missions that a server carries out are recorded, each in a file of its own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from bt_mission_interfaces.action import ExecuteMission
from rclpy.action import ActionClient
from std_msgs.msg import String

from bt_mission.base.errors import BtMissionError
from bt_mission.recording.reader import read_run
from bt_mission.recording.replay.player import Player
from bt_mission.recording.replay.timeline import read_timeline
from bt_mission.recording.served import ServedRecordings, free_file
from bt_mission.recording.verification import RecordedRequirements
from tests.support.mission_goals import Sent

TURN = """\
mission: a turn
inputs: {angle: 90}
requirements:
  is soon over: 'eventually within 5 s: succeeded("turn")'
tree:
  turn: {angle: $angle}
  name: turn
  timeout: 60
"""


@pytest.fixture
def serve(ros: Any, tmp_path: Path) -> Any:
    """Have a mission recorded until its server has the goal; gives that server and the mission."""
    recordings = ServedRecordings(tmp_path / "runs", ros.logged.append)
    ros.serve(onlookers=lambda _: [recordings.onlooker()])
    ros.recordings = recordings
    client, turn = ActionClient(ros.client, ExecuteMission, "execute_mission"), ros.server()

    def start(**fields: Any) -> tuple[Any, Sent]:
        before = len(turn.goals)
        mission = Sent(ros, client, text=TURN, **fields)
        ros.until(lambda: len(turn.goals) > before)
        return turn, mission

    return start


def test_each_mission_has_a_file_that_is_read_as_any_other(
    ros: Any, serve: Any, tmp_path: Path
) -> None:
    """With tree, goal, inputs, summary and requirements, under the name of the server."""
    for number, angle in enumerate((45, 30), start=1):
        turn, mission = serve(inputs=[f"angle={angle}"], seed=7)
        ros.run(1.5)
        turn.goal.succeed()
        assert mission.end()[0] == "succeeded"
        path = tmp_path / "runs" / f"a_turn_{number:03d}.mcap"
        assert f"  recorded to {path}" in ros.logged
        assert ros.recordings.are_whole
        run = read_run(path)
        assert (run.mission, run.node, run.status) == ("a turn", "/bt_mission", "success")
        assert (run.why_cut, run.inputs["angle"], run.facts["seed"]) == ("", angle, "7")
        (goal,) = (recorded for recorded in run.goals if recorded.action == "/turn")
        assert (goal.status, goal.values["angle"]) == ("succeeded", angle)
        assert run.summary["goals_sent"] == 1
        spans = run.spans[0]
        assert (len(spans), spans[0].status) == (1, "success")
        assert (spans[0].end_ns - spans[0].start_ns) / 1e9 == pytest.approx(1.5, abs=0.11)
        result = RecordedRequirements(path)
        assert [judged.verdict for judged in result.verify(result.own()).results] == ["holds"]
        timeline = read_timeline(path)
        player = Player(timeline, at_s=1.0)
        assert player.mission.status == "running"
        player.go(player.duration_s)
        assert player.mission.status == "success"


def test_topics_of_the_graph_are_in_it(ros: Any, serve: Any, tmp_path: Path) -> None:
    """Those that come while it runs, too."""
    turn, mission = serve()
    publisher = ros.client.create_publisher(String, "greeting", 10)
    ros.run(3.0)
    publisher.publish(String(data="hello"))
    ros.run(0.5)
    turn.goal.succeed()
    mission.end()
    timeline = read_timeline(tmp_path / "runs" / "a_turn_001.mcap")
    assert timeline.missing == ""
    assert "/greeting" in RecordedRequirements(tmp_path / "runs" / "a_turn_001.mcap").survey.topics


def test_a_mission_that_is_left_keeps_what_was_recorded(
    ros: Any, serve: Any, tmp_path: Path
) -> None:
    """The file is closed, and says that the mission was abandoned."""
    serve()
    ros.run(2.0)
    ros.served.abandon("left at once")
    run = read_run(tmp_path / "runs" / "a_turn_001.mcap")
    assert (run.status, run.why_cut) == ("interrupted", "")
    assert str(run.summary["reason"]).startswith("left at once; ")


def test_a_mission_that_cannot_be_recorded_is_carried_out(
    ros: Any, serve: Any, tmp_path: Path
) -> None:
    """And it is said why it is not."""
    (tmp_path / "runs").rmdir()
    turn, mission = serve()
    turn.goal.succeed()
    assert mission.end()[0] == "succeeded"
    assert any(line.startswith("not recorded: ") for line in ros.logged)
    assert not ros.recordings.are_whole, "the command fails at its end"


def test_a_recording_that_was_deleted_is_not_said_to_be_there(
    ros: Any, serve: Any, tmp_path: Path
) -> None:
    """The mission ends as it would have."""
    turn, mission = serve()
    path = tmp_path / "runs" / "a_turn_001.mcap"
    path.unlink()
    turn.goal.succeed()
    assert mission.end()[0] == "succeeded"
    lacks = "everything (the file was deleted while it was written)"
    assert f"  recorded to {path}; it lacks {lacks}" in ros.logged
    assert not ros.recordings.are_whole


def test_a_name_of_a_mission_is_no_path(tmp_path: Path) -> None:
    """And a file that is there is not overwritten."""
    assert free_file(tmp_path, "../../etc/x y").name == "etc_x_y_001.mcap"
    assert free_file(tmp_path, "地図").name == "mission_001.mcap"
    (tmp_path / "m_001.mcap").touch()
    assert free_file(tmp_path, "m").name == "m_002.mcap"


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    """Before anything is served."""
    (tmp_path / "file").touch()
    with pytest.raises(BtMissionError, match="--record: "):
        ServedRecordings(tmp_path / "file" / "runs", print)
