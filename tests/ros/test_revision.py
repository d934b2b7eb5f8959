"""A mission is revised over real rclpy: by a service, in topics, journals and recordings."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from bt_mission_interfaces.msg import StatusChanges, Tree
from bt_mission_interfaces.srv import GetStatuses, ReviseMission

from bt_mission.executive.events import reader
from bt_mission.executive.events.feed import MissionFeed
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.language.revision import Revision
from bt_mission.ros.graph import LATCHED
from bt_mission.ros.journal import open_journal, resumed_mission
from bt_mission.ros.status_publisher import CHANGES
from bt_mission.sessions.load import load

TWO = """\
mission: m
tree:
  sequence:
    - turn: {angle: 90}
      name: left
      timeout: 1000000
    - wait: 1
      name: pause
"""
THREE = TWO.replace("  sequence:\n", "  sequence:\n    - log: first\n").replace(
    "wait: 1", "wait: 2"
)


def revise(ros: Any, text: str, **options: Any) -> tuple[bool, str, Revision | None]:
    """Send a new version."""
    answer = ros.call(ReviseMission, "/bt_mission/revise", file="new.yaml", text=text, **options)
    revision = Revision.from_dict(json.loads(answer.revision)) if answer.revision else None
    return answer.success, answer.message, revision


def test_a_version_that_another_process_sends_is_applied(ros: Any) -> None:
    """Viewers that were there before, and those that join later, show the new tree."""
    turn = ros.server()
    runner = ros.mission(TWO, has_controls=True, editable=True)
    state = MissionState()
    seen: list[Any] = []
    feed = MissionFeed(state)
    for kind, topic, qos, read in (
        (Tree, "tree", LATCHED, reader.tree),
        (StatusChanges, "changes", CHANGES, reader.changes),
    ):

        def take(message: Any, read: Any = read) -> None:
            seen.extend(feed.take(read(message)))

        ros.client.create_subscription(kind, f"/bt_mission/{topic}", take, qos)
    ros.spin_until(lambda: turn.goals and state.tree)
    done, _, revision = revise(ros, THREE)
    assert done
    assert revision is not None
    assert ([node.name for node in revision.changes], revision.continues) == (["pause"], ("left",))
    ros.run(0.2)
    assert (turn.goal.cancels, len(turn.goals)) == (0, 1)
    assert state.tree is not None
    assert [node.name for node in state.tree.nodes] == ["m", "log", "left", "pause"]
    assert [status.value[0] for status in state.statuses] == ["R", "I", "R", "I"]
    late = MissionState()
    message: list[Any] = []
    ros.client.create_subscription(Tree, "/bt_mission/tree", message.append, LATCHED)
    ros.spin_until(lambda: message)
    joined = MissionFeed(late)
    joined.take(reader.tree(message[0]))
    joined.take(reader.statuses(ros.call(GetStatuses, "/bt_mission/statuses")))
    assert (late.statuses, late.tree) == (state.statuses, state.tree)
    turn.goal.succeed()
    ros.until(lambda: runner.is_done)
    assert state.statuses == runner.executive.mission_state.statuses
    assert runner.mission.node_at("0.2").seconds == 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TWO.replace("turn", "trun"), "new.yaml:4:7: error: BT-203: unknown node type 'trun'"),
        (TWO.replace("m\n", "other\n", 1), "refused"),
        (TWO.replace("wait: 1", "python: os:Class"), "does not use this Python code: 'os:Class'"),
    ],
)
def test_a_version_that_does_not_fit_is_refused(ros: Any, text: str, message: str) -> None:
    """The response has the reason, and nothing changes."""
    turn, runner = ros.turning(TWO, has_controls=True, editable=True)
    done, why, _ = revise(ros, text)
    assert (done, runner.executive.revisions, turn.goal.cancels) == (False, 0, 0)
    assert message.partition(":")[0] in why
    assert message.rpartition(": ")[2] in why


def test_a_mission_that_is_not_editable_refuses_all_versions(ros: Any) -> None:
    """The message says how to start it."""
    ros.server()
    ros.mission(TWO, has_controls=True)
    done, why, _ = revise(ros, THREE)
    assert not done
    assert "`bt-mission run MISSION --editable`" in why


def test_a_resumed_mission_is_the_revised_one(ros: Any, tmp_path: Path) -> None:
    """The journal has the new version in the transaction of the revision."""
    path = tmp_path / "journal"
    turn = ros.server()
    first = ros.mission(TWO, has_controls=True, editable=True)
    journal = open_journal(path, first.mission, first, resume=False)
    ros.until(lambda: turn.goals)
    assert revise(ros, THREE)[0]
    turn.goal.succeed()
    ros.run(1.0)
    journal.close()  # the process has died
    first.close()
    mission = resumed_mission(path, load(TWO))
    second = ros.mission(mission.document)
    journal = open_journal(path, mission, second, resume=True)
    began_s = ros.now_s
    took_s = ros.until(lambda: second.is_done) - began_s
    journal.close()
    assert (len(turn.goals), took_s) == (1, pytest.approx(1.25, abs=0.05))
    assert (second.executive.status, second.executive.reason) == ("success", "")
    names = [node.name for node in second.executive.nodes]
    assert (names, ros.logged) == (["m", "log", "left", "pause"], [])


def test_a_recording_has_the_tree_of_each_time(tmp_path: Path) -> None:
    """And the files of the new version; two runs with the same revision have the same trace."""
    from bt_mission.recording.reader import read_run  # noqa: PLC0415 - the same
    from bt_mission.recording.replay.player import TimelineSeeker  # noqa: PLC0415 - is slow
    from bt_mission.recording.replay.timeline import read_timeline  # noqa: PLC0415 - the same
    from bt_mission.recording.writer import record  # noqa: PLC0415 - the same
    from bt_mission.sessions.stage import Stage  # noqa: PLC0415 - the same

    hashes = []
    for number in (1, 2):
        path = tmp_path / f"{number}.mcap"
        with Stage(load(TWO + "world: empty_arena\n"), image_folder=tmp_path) as stage:
            with record(stage, path) as recorder:
                while stage.now_ns < 2_000_000_000:
                    stage.step()
                move = "    - move: {secs: 1, linear_velocity: 0.1}\n    - wait"
                new = THREE.replace("    - wait", move) + "world: empty_arena\n"
                assert stage.runner.revise(load(new)).is_applied
                while not stage.is_done:
                    stage.step()
                recorder.finish({})
            assert stage.executive.reason == ""
            hashes.append(stage.trace.sha256)
    assert hashes[0] == hashes[1]
    run = read_run(tmp_path / "1.mcap")
    assert "move" in run.files["revision_1/<text>"]
    assert [node.name for node in run.tree] == ["m", "log", "left", "move", "pause"]
    assert [len(spans) for spans in run.spans] == [1, 0, 1, 1, 1]
    timeline = read_timeline(tmp_path / "1.mcap")
    starts_ns = {key[1:]: times_ns for key, times_ns in timeline.starts_ns.items()}
    assert starts_ns.keys() == {(0, 0), (0, 1), (0, 2), (1, 0), (1, 2), (1, 3), (1, 4)}
    for first, second in ((0, 0), (1, 2), (2, 4)):
        assert starts_ns[0, first] == starts_ns[1, second], "of one node in both trees"
    seeker = TimelineSeeker(timeline)
    before = seeker.seek(1_900_000_000).tree
    after = seeker.seek(2_100_000_000)
    assert before is not None
    assert after.tree is not None
    assert [node.name for node in before.nodes] == ["m", "left", "pause"]
    assert [node.name for node in after.tree.nodes] == ["m", "log", "left", "move", "pause"]
    assert [status.value[0] for status in after.statuses] == ["R", "I", "R", "I", "I"]
