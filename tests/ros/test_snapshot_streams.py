"""Streams of snapshots, as the tree watcher of py_trees_ros asks for them, over real rclpy."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from bt_mission_interfaces.action import ExecuteMission
from py_trees_ros_interfaces.msg import Behaviour
from py_trees_ros_interfaces.srv import OpenSnapshotStream, ReconfigureSnapshotStream
from rclpy.action import ActionClient
from std_msgs.msg import String

from bt_mission.ros import snapshot_streams
from bt_mission.ros.snapshot_streams import MOST_STREAMS
from tests.support.tree_watcher import TreeWatcher, parameters

OPEN = "/bt_mission/snapshot_streams/open"
RECONFIGURE = "/bt_mission/snapshot_streams/reconfigure"
EVERYTHING = """\
mission: all kinds
inputs: {speed: 0.5}
tree:
  sequence:
    - set: {n: 3}
    - parallel:
        - wait: 1e6
          name: first
        - turn: {angle: 90}
          timeout: 1e8
      succeed_when: any
    - fallback:
        - check: n > 5
        - when: n > 2
          do:
            log: ok
    - repeat: {count: 2}
      do:
        log: round
"""
TURN = """\
mission: m
tree:
  sequence:
    - turn: {angle: 90}
      timeout: 1e8
    - wait: 1e6
"""
WAITS = "mission: m\ntree:\n  sequence:\n    - wait: 1\n    - wait: 1e6\n      name: long\n"


@pytest.fixture(autouse=True)
def _as_fast_as_virtual_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(snapshot_streams, "SHORTEST_S", 0.0)


def test_the_watcher_finds_the_tree_and_draws_it(ros: Any):
    """Every kind of node is one that it knows, and each status and message is there."""
    turn = ros.server()
    node = ros.mission(EVERYTHING, has_controls=True)
    watcher = TreeWatcher(ros)
    ros.until(lambda: turn.goals)
    ros.spin_until(lambda: "first [*]" in "\n".join(watcher.drawn()))
    assert watcher.drawn()[:5] == [
        "{-} all kinds [*]",
        "  --> set n [o] -- n = 3",
        "  /_/ parallel [*]",
        "    --> first [*] -- 1000000.0 s left",
        "    --> turn [*] -- waiting for acceptance",
    ]
    turn.goal.succeed()
    ros.until(lambda: node.is_done)
    ros.spin_until(lambda: watcher.newest.behaviours[-1].status == Behaviour.SUCCESS)
    assert "    {o} when n > 2" in [line.partition(" [")[0] for line in watcher.drawn()]


def test_a_node_is_described_in_py_trees_words(ros: Any):
    """Its class, its policy, its memory, the child that is its turn, and its tip."""
    ros.server()
    ros.mission(EVERYTHING, has_controls=True)
    ros.run(0.2)
    watcher = TreeWatcher(ros)
    nodes = {behaviour.name: behaviour for behaviour in watcher.newest.behaviours}
    root, parallel = nodes["all kinds"], nodes["parallel"]
    assert root.class_name == "bt_mission.executive.behaviours.control.Sequence"
    assert (root.additional_detail, parallel.additional_detail) == ("WithMemory", "OnOne")
    assert root.current_child_id == parallel.own_id
    assert root.tip_id == nodes["turn"].own_id
    assert not any(nodes["turn"].tip_id.uuid)
    assert root.blackbox_level == Behaviour.BLACKBOX_LEVEL_NOT_A_BLACKBOX
    order = [behaviour.name for behaviour in watcher.newest.behaviours]
    assert (order[0], order[-1]) == ("set n", "all kinds")  # children before their parents


def test_each_tool_has_a_stream_until_it_closes_it(ros: Any):
    """A stream that is closed has no publisher any more, and cannot be closed again."""
    ros.mission(WAITS, has_controls=True)
    first, second = (TreeWatcher(ros) for _ in range(2))
    assert first.topic != second.topic
    assert first.close()
    assert ros.client.count_publishers(first.topic) == 0
    assert ros.client.count_publishers(second.topic) == 1
    assert not first.close()


def test_a_stream_without_a_period_tells_of_changes_only(ros: Any):
    """The first snapshot is the tree as it stands; each says that there is a change."""
    turn, _ = ros.turning(TURN, has_controls=True)
    watcher = TreeWatcher(ros)
    assert watcher.drawn() == [
        "{-} m [*]",
        "  --> turn [*] -- waiting for acceptance",
        "  --> wait",
    ]
    turn.goal.feed(current_angle=10.0)
    ros.run(1.0)
    assert len(watcher.snapshots) == 1
    turn.goal.succeed()
    watcher.wait_for(2)
    ros.run(1.0)
    assert [snapshot.changed for snapshot in watcher.snapshots] == [True, True]
    assert watcher.drawn()[0] == "{-} m [*]"
    assert watcher.drawn()[2] == "  --> wait [*] -- 1000000.0 s left"


def test_a_period_of_nothing_tells_of_every_tick(ros: Any):
    """With its number, its time on the mission's clock, and the interval between ticks."""
    ros.mission(WAITS, has_controls=True)
    watcher = TreeWatcher(ros, 0.0)
    assert watcher.newest
    ros.run(2.0)
    counts = [snapshot.statistics.count for snapshot in watcher.snapshots]
    assert counts[-20:] == list(range(counts[-1] - 19, counts[-1] + 1))
    ticks = watcher.newest.statistics
    assert ticks.tick_interval == pytest.approx(0.05)
    assert ticks.tick_interval_average == pytest.approx(0.05)
    assert ticks.tick_interval_variance == pytest.approx(0.0)
    assert 0 < ticks.tick_duration_average < 1
    assert ticks.stamp.sec + ticks.stamp.nanosec / 1e9 == pytest.approx(
        ros.clock.now_ns / 1e9, abs=0.06
    )


def test_the_blackboard_is_the_variables(ros: Any):
    """As JSON, where they are asked for; nobody keeps who accessed them."""
    ros.server()
    ros.mission(EVERYTHING, has_controls=True)
    ros.run(0.2)
    with_data = TreeWatcher(ros, blackboard_data=True, blackboard_activity=True)
    results = with_data.newest.blackboard_on_visited_path
    assert {result.key: result.value for result in results} == {"speed": "0.5", "n": "3"}
    assert with_data.newest.blackboard_activity == []
    assert TreeWatcher(ros).newest.blackboard_on_visited_path == []


def test_a_stream_may_be_given_a_name_and_another_period(ros: Any):
    """A relative name lies below that of the node; who asks for it again shares it."""
    ros.mission(WAITS, has_controls=True)
    watcher = TreeWatcher(ros, topic="mine")
    assert watcher.topic == "/bt_mission/snapshot_streams/mine"
    assert TreeWatcher(ros, topic="~/snapshots").topic == "/bt_mission/snapshots"
    assert TreeWatcher(ros, topic="/elsewhere").topic == "/elsewhere"
    assert TreeWatcher(ros, topic="mine").topic == watcher.topic
    ros.run(2.0)
    count = len(watcher.snapshots)
    asked = {"topic_name": watcher.topic, "parameters": parameters(0.0)}
    assert ros.call(ReconfigureSnapshotStream, RECONFIGURE, **asked).result
    ros.run(1.0)
    assert len(watcher.snapshots) > count + 10
    asked["topic_name"] = "/nowhere"
    assert not ros.call(ReconfigureSnapshotStream, RECONFIGURE, **asked).result


@pytest.mark.parametrize("period_s", [math.nan, -1.0, -math.inf])
def test_a_senseless_period_is_refused(
    ros: Any, capfd: pytest.CaptureFixture[str], period_s: float
):
    """The answer has no room for the reason: the log has it."""
    ros.mission(WAITS, has_controls=True)
    watcher = TreeWatcher(ros)
    nonsense = {"parameters": parameters(period_s)}
    assert ros.call(OpenSnapshotStream, OPEN, **nonsense).topic_name == ""
    nonsense["topic_name"] = watcher.topic
    assert not ros.call(ReconfigureSnapshotStream, RECONFIGURE, **nonsense).result
    assert "snapshot_period: expected seconds from 0, or inf, got" in capfd.readouterr().err


@pytest.mark.parametrize(
    "topic", ["a b", "/", "//x", "x/", "~~", "{}", "x" * 300, "/chatter", "\n"]
)
def test_a_name_that_cannot_be_is_refused(ros: Any, topic: str):
    """Also that of a topic on which others send something else; the mission goes on."""
    ros.client.create_publisher(String, "/chatter", 1)
    node = ros.mission(WAITS, has_controls=True)
    asked = {"topic_name": topic, "parameters": parameters()}
    assert ros.call(OpenSnapshotStream, OPEN, **asked).topic_name == ""
    ros.run(0.5)
    assert node.status == "running"
    assert TreeWatcher(ros).newest.behaviours


def test_there_is_room_for_so_many_streams(ros: Any, monkeypatch: pytest.MonkeyPatch):
    """Then for none, until that of a killed watcher is dropped after a while."""
    ros.mission(WAITS, has_controls=True)
    watchers = [TreeWatcher(ros) for _ in range(MOST_STREAMS)]
    watchers[3].leave()

    def kept() -> list[bool]:
        ros.run(0.2)
        return [ros.client.count_publishers(watcher.topic) == 1 for watcher in watchers]

    assert all(kept())
    asked = {"parameters": parameters()}
    assert ros.call(OpenSnapshotStream, OPEN, **asked).topic_name == ""
    monkeypatch.setattr(snapshot_streams, "SILENT_S", 0.0)
    assert kept() == [number != 3 for number in range(MOST_STREAMS)]
    assert ros.call(OpenSnapshotStream, OPEN, **asked).topic_name != ""


def test_virtual_time_does_not_flood_a_watcher(ros: Any, monkeypatch: pytest.MonkeyPatch):
    """Snapshots keep a distance in wall time; the end of the mission is always told."""
    monkeypatch.setattr(snapshot_streams, "SHORTEST_S", 1e6)
    text = "mission: m\ntree:\n  sequence:\n" + "    - wait: 0.1\n" * 30
    node = ros.mission(text, has_controls=True)
    node.executive.pause("held")  # until the stream is matched, which takes time of the wall
    watcher = TreeWatcher(ros)
    watcher.wait_for(1)
    node.executive.resume()
    ros.until(lambda: node.is_done)
    watcher.wait_for(2)
    ros.run(0.2)
    assert len(watcher.snapshots) == 2
    assert watcher.newest.changed
    assert watcher.newest.behaviours[-1].status == Behaviour.SUCCESS


def test_a_paused_mission_can_be_watched(ros: Any):
    """What was visited before the stream was there is not known: what has a status counts."""
    node = ros.mission(WAITS, has_controls=True)
    ros.run(0.3)
    node.executive.pause("held")
    ros.run(0.3)
    assert TreeWatcher(ros).drawn() == ["{-} m [*]", "  --> wait [*] -- 0.8 s left", "  --> long"]


def test_a_node_may_be_destroyed_under_an_open_stream(ros: Any):
    """The mission ends as failed, and nothing else goes wrong."""
    runner = ros.mission(WAITS, has_controls=True)
    assert TreeWatcher(ros).newest
    ros.drop(runner.node)
    assert runner.is_done
    runner.close()
    assert runner.executive.reason == "its node was destroyed"


def test_a_server_streams_one_mission_after_another(ros: Any):
    """Nothing before the first, and the last one until the next."""
    server = ros.serve()
    watcher = TreeWatcher(ros)
    ros.run(0.3)
    assert watcher.snapshots == []
    client = ActionClient(ros.client, ExecuteMission, "execute_mission")
    for name in ("one", "two"):
        text = f"mission: {name}\ntree:\n  sequence: [{{wait: 0.2}}]\n"
        ros.until(client.send_goal_async(ExecuteMission.Goal(text=text)).done)
        ros.until(lambda: not server.is_busy)
        ros.run(0.2)
        assert watcher.drawn() == [f"{{-}} {name} [o]", "  --> wait [o] -- 0.0 s left"]
        assert TreeWatcher(ros).drawn() == watcher.drawn()


LEAF = """\
import py_trees


class Look(py_trees.behaviour.Behaviour):
    def __init__(self, name):
        super().__init__(name)
        client = self.attach_blackboard_client()
        client.register_key("seen", py_trees.common.Access.WRITE)
        client.register_key("goal", py_trees.common.Access.READ)

    def update(self):
        return py_trees.common.Status.RUNNING
"""


def test_a_python_leaf_is_shown_as_the_behaviour_that_it_is(
    ros: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Its class, and what its blackboard clients may access."""
    (tmp_path / "looking.py").write_text(LEAF, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    ros.mission("mission: m\ntree: {python: 'looking.py:Look'}\n", has_controls=True)
    ros.run(0.2)
    watcher = TreeWatcher(ros)
    (look,) = watcher.newest.behaviours
    assert look.class_name.endswith(".Look")
    assert [(access.key, access.value) for access in look.blackboard_access] == [
        ("/goal", "r"),
        ("/seen", "w"),
    ]
    assert watcher.drawn() == ["--> Look [*]"]
