"""A watcher's ears and hands over real rclpy, in one process."""

from __future__ import annotations

from typing import Any

import pytest
from bt_mission_interfaces import msg
from nav_msgs.msg import OccupancyGrid
from py_trees.common import Status
from rclpy.type_hash import TypeHash
from sensor_msgs.msg import BatteryState
from visualization_msgs.msg import Marker, MarkerArray

from bt_mission.executive.events import messages
from bt_mission.executive.events.feed import MissionFeed
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.events.source import ControlRequest, ControlResponse, Verb
from bt_mission.ros.discovery import ExecutiveDirectory
from bt_mission.ros.graph import LATCHED, type_hash_of
from bt_mission.ros.mission_client import MissionClient

# A watcher finds the graph in wall time, while virtual time runs on: no limit is ever reached.
TWO = "mission: m\ntree:\n  sequence:\n    - turn: {angle: 90}\n      timeout: 1e8\n    - wait: 1\n"


class Watcher:
    """A link, and what is known through it."""

    def __init__(self, ros: Any, name: str = "/bt_mission") -> None:
        self.link = MissionClient(ros.client, name)
        self.mission = MissionState()
        self.feed = MissionFeed(self.mission)
        self.answers: list[ControlResponse] = []
        self.robot: list[messages.Robot] = []

    def look(self) -> MissionState:
        """Take what has come."""
        received = self.link.take(needs_statuses=self.feed.needs_statuses)
        for batch in received.messages:
            self.feed.take(batch)
        self.answers += received.answers
        self.robot += received.robot
        return self.mission

    @property
    def is_complete(self) -> bool:
        """Take what has come; gives whether all statuses are known."""
        self.look()
        return not self.feed.needs_statuses

    def answered(self, count: int) -> bool:
        """Take what has come; gives whether there are so many answers."""
        self.look()
        return len(self.answers) >= count


def test_watchers_that_start_at_once_find_their_types(ros: Any):
    """Their nodes have the same name, and so has whatever the other one subscribes to meanwhile."""
    expected = type_hash_of(ros.client, BatteryState)
    ros.client.create_subscription(msg.Tree, "~/probe", lambda _: None, 1)
    assert type_hash_of(ros.client, BatteryState) == expected


def test_a_mission_is_followed_from_its_first_tick(ros: Any):
    """Tree, statuses, state, goals and progress."""
    watcher, turn = Watcher(ros), ros.server()
    ros.mission(TWO, has_controls=True)
    ros.until(lambda: turn.goals)
    ros.run(0.1)
    mission = watcher.look()
    assert mission.tree is not None
    assert [node.name for node in mission.tree.nodes] == ["m", "turn", "wait"]
    assert (mission.tip, mission.status) == (1, "running")
    turn.goal.succeed()
    ros.spin_until(lambda: watcher.look().status == "success")
    assert mission.statuses == [Status.SUCCESS] * 3
    assert [goal.state for goal in mission.goals.values()] == ["succeeded"]


def test_who_comes_late_has_the_same_picture(ros: Any):
    """Statuses are asked for; the latched tree and state come by themselves."""
    ros.turning(TWO, has_controls=True)
    watcher = Watcher(ros)
    ros.spin_until(lambda: watcher.look().tree is not None)
    ros.spin_until(lambda: watcher.is_complete)
    assert watcher.mission.statuses == [Status.RUNNING, Status.RUNNING, Status.INVALID]


@pytest.mark.parametrize(
    ("verb", "state"),
    [(Verb.PAUSE, "paused"), (Verb.PAUSE_KEEPING_GOALS, "paused"), (Verb.STOP, "interrupted")],
)
def test_wishes_are_passed_on(ros: Any, verb: Verb, state: str):
    """And answered in words."""
    watcher, turn = Watcher(ros), ros.server()
    node = ros.mission(TWO, has_controls=True)
    ros.until(lambda: turn.goals)
    watcher.link.send(ControlRequest(verb))
    ros.spin_until(lambda: watcher.look().status == state)
    assert [answer.is_done for answer in watcher.answers] == [True]
    assert (turn.goal.cancels > 0) is (verb is not Verb.PAUSE_KEEPING_GOALS)
    assert node.executive.mission_state.status == state


def test_a_breakpoint_is_set_and_removed_by_its_path(ros: Any):
    """Names may be given twice in a tree, paths are not."""
    watcher = Watcher(ros)
    node = ros.mission(TWO, has_controls=True)
    watcher.link.send(ControlRequest(Verb.BREAK, "0.1"))
    ros.spin_until(lambda: watcher.answered(1))
    assert node.executive.breakpoints.names == ("0.1",)
    watcher.link.send(ControlRequest(Verb.UNBREAK, "0.1"))
    watcher.link.send(ControlRequest(Verb.STEP))
    ros.spin_until(lambda: watcher.answered(3))
    assert node.executive.breakpoints.names == ()
    assert watcher.answers[2] == ControlResponse(False, "the mission is not paused; pause it first")


def test_without_an_executive_a_wish_is_answered_too(ros: Any):
    """By name of what is not there."""
    watcher = Watcher(ros, "/robot9/bt_mission")
    watcher.link.send(ControlRequest(Verb.RESUME))
    watcher.look()
    assert watcher.answers == [ControlResponse(False, "/robot9/bt_mission/resume has no server")]
    assert not watcher.link.is_there


def test_a_robot_is_heard_in_the_namespace_of_its_executive(ros: Any):
    """Of readings the newest; nothing is kept while nobody takes it."""
    watcher = Watcher(ros, "/robot1/bt_mission")
    battery = ros.client.create_publisher(BatteryState, "/robot1/battery_state", 10)
    grid = ros.client.create_publisher(OccupancyGrid, "/robot1/map", LATCHED)
    zones = ros.client.create_publisher(MarkerArray, "/robot1/zones", LATCHED)
    ros.run(0.2)
    grid.publish(OccupancyGrid())
    dock = Marker(type=Marker.CYLINDER)
    dock.scale.x = 1.0
    zones.publish(MarkerArray(markers=[dock]))
    for percentage in (80.0, 79.0):
        battery.publish(BatteryState(percentage=percentage, voltage=11.5))
    ros.run(0.2)
    watcher.look()
    reports = {messages.Map, messages.Zones, messages.BatteryState}
    assert {type(message) for message in watcher.robot} == reports
    assert messages.BatteryState(79.0, 11.5) in watcher.robot
    watcher.look()
    assert len(watcher.robot) == 3


def test_a_link_that_is_closed_leaves_nothing_behind(ros: Any):
    """As many subscriptions and clients as before."""
    before = len([*ros.client.subscriptions]), len([*ros.client.clients])
    link = MissionClient(ros.client, "/bt_mission")
    link.close()
    assert (len([*ros.client.subscriptions]), len([*ros.client.clients])) == before


def test_executives_are_found_by_what_they_publish(monkeypatch: pytest.MonkeyPatch):
    """By name; two of one name, and those of another version, are told."""
    with ExecutiveDirectory() as observer:

        def publish(name: str) -> None:
            observer._node.create_publisher(msg.MissionState, f"{name}/state", LATCHED)

        def find() -> dict[str, str]:
            return {executive.name: executive.problem for executive in observer.find()}

        assert find() == {}
        publish("/robot2/bt_mission")
        publish("/robot1/bt_mission")
        assert find() == {"/robot1/bt_mission": "", "/robot2/bt_mission": ""}
        publish("/robot1/bt_mission")
        assert find()["/robot1/bt_mission"].startswith("2 executives share this name")
        monkeypatch.setattr(observer, "_hashes", [TypeHash()] * 5)
        assert [executive.is_foreign for executive in observer.find()] == [True, True]
        assert find()["/robot2/bt_mission"].startswith(
            "its MissionState messages are from another version"
        )
