"""A tree of py_trees_ros as a watcher hears it, over real rclpy in one process."""

from __future__ import annotations

from typing import Any

import pytest
from py_trees.common import Status
from py_trees_ros_interfaces.msg import Behaviour
from rclpy.type_hash import TypeHash

from bt_mission.events.mission_state import MissionState
from bt_mission.events.source import ControlRequest, Verb
from bt_mission.ros import snapshot_client
from bt_mission.ros.snapshot_client import SnapshotClient
from tests.support.peer_tree import TREE, PeerTree

TWO = "mission: m\ntree:\n  sequence:\n    - turn: {angle: 90}\n      timeout: 1e8\n    - wait: 1\n"


class Watcher:
    """A client, and what is known through it."""

    def __init__(self, ros: Any, name: str = "/tree", **options: Any) -> None:
        self.link = SnapshotClient(ros.client, name, **options)
        self.mission = MissionState()
        self.answers: list[str] = []

    def look(self) -> MissionState:
        """Take what has come."""
        heard = self.link.take(needs_statuses=self.mission.needs_statuses)
        for message in heard.messages:
            self.mission.take(message)
        self.answers += [answer.text for answer in heard.answers]
        return self.mission


@pytest.fixture
def peer(ros: Any) -> PeerTree:
    """A tree on a node of its own."""
    return PeerTree(ros.node("tree"))


def test_a_tree_is_followed_live(ros: Any, peer: PeerTree):
    """Statuses, and what a node says meanwhile."""
    watcher = Watcher(ros)
    ros.until_heard(lambda: watcher.look().tree)
    assert watcher.mission.tree is not None
    assert [one.name for one in watcher.mission.tree.nodes] == ["root", "leaf"]
    assert watcher.mission.status == "running"
    peer.tell(message="2 m left")
    ros.until_heard(lambda: watcher.look().messages[1] == "2 m left")
    peer.tell(Behaviour.SUCCESS, "there")
    ros.until_heard(lambda: watcher.look().status == "success")
    assert watcher.mission.statuses == [Status.SUCCESS] * 2


@pytest.mark.parametrize("wanted", [False, True])
def test_variables_are_asked_for_where_they_are_wanted(ros: Any, peer: PeerTree, *, wanted: bool):
    """The process of the tree has work with them; accesses are never asked for."""
    watcher = Watcher(ros, has_variables=wanted)
    ros.until_heard(lambda: watcher.look().tree)
    (asked,) = peer.asked
    assert asked.parameters.blackboard_data is wanted
    assert not asked.parameters.blackboard_activity
    assert asked.parameters.snapshot_period == 0.5


@pytest.mark.parametrize("verb", list(Verb))
def test_what_cannot_be_done_is_said(ros: Any, peer: PeerTree, verb: Verb):
    """Of every wish."""
    watcher = Watcher(ros)
    watcher.link.send(ControlRequest(verb))
    watcher.look()
    (answer,) = watcher.answers
    assert answer.startswith("not available: /tree is a tree of py_trees_ros")


def test_the_stream_is_closed_at_the_end(ros: Any, peer: PeerTree):
    """And nothing is left behind but the node's own."""
    watcher = Watcher(ros)
    ros.until_heard(lambda: watcher.look().tree)
    assert len(peer.streams) == 1
    watcher.link.close()
    ros.until_heard(lambda: watcher.link.is_closed)
    assert peer.streams == {}
    assert [*ros.client.subscriptions] == []


def test_a_stream_that_is_only_just_asked_for_is_closed_too(ros: Any, peer: PeerTree):
    """Its answer comes after the watcher has left."""
    watcher = Watcher(ros)
    ros.until_heard(lambda: watcher.link.is_there)
    watcher.look()
    watcher.link.close()
    assert not watcher.link.is_closed
    ros.until_heard(lambda: watcher.link.is_closed)
    assert (len(peer.asked), peer.streams) == (1, {})


def test_another_stream_is_opened_when_one_breaks(
    ros: Any, peer: PeerTree, monkeypatch: pytest.MonkeyPatch
):
    """The tree has begun anew, or has dropped it; also when it comes back."""
    monkeypatch.setattr(snapshot_client, "GONE_S", 0.0)
    watcher = Watcher(ros)
    ros.until_heard(lambda: watcher.look().tree)
    peer.drop_streams()
    ros.until_heard(lambda: watcher.look().tree and peer.streams)
    assert len(peer.asked) == 2
    peer.leave()
    ros.until_heard(lambda: watcher.look().tree and not watcher.link.is_there)
    assert [*ros.client.subscriptions] == []
    again = PeerTree(ros.node("tree"))
    ros.until_heard(lambda: watcher.look().tree and again.streams)
    again.tell(Behaviour.FAILURE)
    ros.until_heard(lambda: watcher.look().status == "failure")


def test_a_refusal_is_said(ros: Any, peer: PeerTree, monkeypatch: pytest.MonkeyPatch):
    """It is asked again after a while."""
    peer.refuses = True
    watcher = Watcher(ros)
    ros.until_heard(lambda: watcher.look().state)
    assert watcher.mission.state is not None
    assert watcher.mission.state.reason == "it opened no stream: its own log says why"
    monkeypatch.setattr(snapshot_client, "ANSWER_S", 0.0)
    peer.refuses = False
    ros.until_heard(lambda: watcher.look().tree)


@pytest.mark.parametrize(("version", "is_read"), [(1, False), (-1, True)])
def test_snapshots_of_another_version_are_not_read(
    ros: Any, peer: PeerTree, monkeypatch: pytest.MonkeyPatch, version: int, *, is_read: bool
):
    """A peer that does not tell its version, such as an older ROS, is taken at its word."""
    infos = ros.client.get_publishers_info_by_topic

    def told(topic: str) -> Any:
        found = infos(topic)
        for one in found:
            one.topic_type_hash = TypeHash(version, bytes(32))
        return found

    monkeypatch.setattr(ros.client, "get_publishers_info_by_topic", told)
    watcher = Watcher(ros)
    ros.until_heard(lambda: watcher.look().state)
    assert (watcher.mission.tree is not None) is is_read
    if not is_read:
        assert watcher.mission.state is not None
        assert "another version of py_trees_ros_interfaces" in watcher.mission.state.reason


def test_a_broken_tree_is_no_end(ros: Any, peer: PeerTree):
    """What is wrong is said until it is mended."""
    watcher = Watcher(ros)
    ros.until_heard(lambda: watcher.look().tree)
    peer.tell(nodes=[("root", "leaf", ("leaf",)), ("leaf", "root", ("root",))])
    ros.until_heard(lambda: watcher.look().status == "unreadable")
    peer.tell(Behaviour.SUCCESS, nodes=TREE)
    ros.until_heard(lambda: watcher.look().status == "success")


def test_an_executive_of_ours_can_be_watched_so_as_well(ros: Any):
    """Both sides speak of the same things: its tree comes out as it went in."""
    turn = ros.server()
    node = ros.mission(TWO, has_controls=True)
    watcher = Watcher(ros, "/bt_mission", has_variables=True)
    ros.until_heard(lambda: turn.goals)
    ros.until_heard(lambda: watcher.look().tree)
    assert watcher.mission.tree is not None
    assert [(one.name, one.kind, one.path) for one in watcher.mission.tree.nodes] == [
        (one.name, type(one).__name__, node.executive.path_of(one)) for one in node.executive.nodes
    ]
    turn.goal.succeed()
    ros.until_heard(lambda: watcher.look().status == "success")
    assert watcher.mission.statuses == [Status.SUCCESS] * 3
