"""What a mission does, told to who listens, over real rclpy on a virtual clock."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

import pytest
from bt_mission_interfaces.msg import MissionDetails, MissionLog
from visualization_msgs.msg import Marker

from bt_mission.executive.events.events import GoalChanged
from bt_mission.executive.goals.poses import NamedPose
from bt_mission.ros import event_messages, mission_details, status_publisher
from bt_mission.ros.mission_details import KEPT_GOALS, as_json
from bt_mission.ros.status_publisher import DETAILS, LOG
from bt_mission.ros.waypoint_markers import MOST, WaypointMarkers

TURN = """\
mission: m
inputs: {angle: 90}
tree:
  sequence:
    - log: off we go
    - turn: {angle: $angle}
      cancel_when: current_angle >= 45
      on_cancel: success
      timeout: 60
      outputs: {angle_turned: turned}
    - wait: 30
"""


@pytest.fixture
def messages(ros: Any, monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What the details carry: one message for each tick."""
    monkeypatch.setattr(status_publisher, "DETAILS_PERIOD_S", 0.0)
    messages: list[Any] = []
    ros.client.create_subscription(MissionDetails, "/bt_mission/details", messages.append, DETAILS)
    return messages


def test_a_running_leaf_tells_how_far_it_is(ros: Any, messages: list[Any]):
    """Towards the bound of its condition; with what it says, and since when."""
    turn, _ = ros.turning(TURN, has_controls=True)
    turn.goal.feed(current_angle=30.0, remaining_angle=60.0)
    ros.run(0.2)
    (leaf,) = (running for running in messages[-1].running if running.label)
    assert (leaf.node, leaf.label, leaf.value, leaf.limit) == (2, "current_angle", 30.0, 45.0)
    assert leaf.message.startswith("current_angle 30.00")
    assert leaf.since.sec == 1


def test_a_wait_tells_how_long_it_takes(ros: Any, messages: list[Any]):
    """Its time towards its end, s; breakpoints are told as they were named."""
    node = ros.mission("mission: m\ntree:\n  wait: 30\n", has_controls=True)
    ros.run(3.0)
    (leaf,) = messages[-1].running
    assert (leaf.label, leaf.limit) == ("s", 30.0)
    assert leaf.value == pytest.approx(2.95)
    node.executive.breakpoints.add("0")
    ros.run(0.2)
    assert messages[-1].breakpoints == ["0"]


def test_a_goal_is_told_when_its_state_changes(ros: Any, messages: list[Any]):
    """Also when the server accepts it, which the ledger has no event for."""
    turn, node = ros.turning(TURN, has_controls=True)
    ros.run(0.2)
    turn.goal.succeed(angle_turned=90.0)
    ros.run(0.2)
    states = [goal.state for message in messages for goal in message.goals]
    assert list(dict.fromkeys(states)) == ["sent", "active", "succeeded"]
    (goal,) = {goal.goal_id: goal for details in messages for goal in details.goals}.values()
    assert (goal.action, goal.owner, len(goal.goal_id)) == ("/turn", "turn", 32)
    assert messages[-1].goals_sent == node.ledger.goals_sent == 1


def test_variables_are_told_once_and_again_for_latecomers(ros: Any, messages: list[Any]):
    """Inputs first, outputs when they are written; every tenth message has all."""
    turn, _ = ros.turning(TURN, has_controls=True)
    turn.goal.succeed(angle_turned=90.0)
    ros.run(2.0)
    reports = [
        {variable.name: json.loads(variable.value) for variable in message.variables}
        for message in messages
    ]
    assert [report for report in reports if report][:2] == [{"angle": 90}, {"turned": 90.0}]
    assert reports[10] == reports[20] == {"angle": 90, "turned": 90.0}
    assert reports[11] == {}


def test_places_of_a_goal_are_told(ros: Any, messages: list[Any]):
    """Those of its poses, for maps."""
    ros.server("follow_waypoints", "nav2_msgs/action/FollowWaypoints")
    text = "mission: m\ntree:\n  follow_waypoints: {poses: [[1, 2, 90], [3, 4, 0]]}\n"
    ros.mission(text, has_controls=True)
    ros.run(1.0)
    (goal,) = messages[-1].goals or next(message.goals for message in messages if message.goals)
    assert [(target.x, target.y) for target in goal.targets] == [(1.0, 2.0), (3.0, 4.0)]


def test_what_is_said_is_told(ros: Any):
    """Each line, with its time."""
    lines: list[Any] = []
    ros.client.create_subscription(MissionLog, "/bt_mission/log", lines.append, LOG)
    ros.mission("mission: m\ntree:\n  log: off we go\n", has_controls=True)
    ros.run(1.0)
    assert [(line.text, line.stamp.sec) for line in lines] == [("off we go", 1)]


def test_nothing_is_made_up_for_nobody(ros: Any, monkeypatch: pytest.MonkeyPatch):
    """Without a subscription there is no message, and no line of the log."""
    monkeypatch.setattr(status_publisher, "DETAILS_PERIOD_S", 0.0)
    made: list[str] = []
    ros.mission("mission: m\ntree:\n  sequence: [{log: hello}, {wait: 5}]\n", has_controls=True)
    for place, name in (
        (event_messages, "MissionLog"),
        (mission_details, "MissionDetails"),
        (event_messages, "NodeProgress"),
        (mission_details, "Variable"),
    ):
        monkeypatch.setattr(place, name, lambda name=name, **_: made.append(name))
    ros.run(10.0)
    assert made == []


def test_wall_time_paces_the_details(
    ros: Any, messages: list[Any], monkeypatch: pytest.MonkeyPatch
):
    """However fast virtual time runs: only a new state of the mission does not wait."""
    monkeypatch.setattr(status_publisher, "DETAILS_PERIOD_S", 3600.0)
    node = ros.mission("mission: m\ntree:\n  wait: 60\n", has_controls=True)
    ros.run(30.0)
    assert len(messages) == 1
    node.executive.pause("by hand")
    ros.run(30.0)
    assert len(messages) == 2


def test_old_goals_are_forgotten(ros: Any, messages: list[Any]):
    """A mission of a week does not grow."""
    turn = ros.server()
    text = "mission: m\ntree:\n  repeat: {count: 70}\n  do:\n    turn: {angle: 9}\n"
    node = ros.mission(text, has_controls=True)
    for count in range(1, 71):
        ros.until(lambda count=count: len(turn.goals) == count)
        turn.goal.succeed()
    ros.until(lambda: node.executive.is_done)
    ros.run(1.0)
    complete = max(len(message.goals) for message in messages)
    assert KEPT_GOALS <= complete <= KEPT_GOALS + 1


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (6, "6"),
        ([1.5, "a"], '[1.5, "a"]'),
        ("x" * 300, None),
        (list(range(1000)), f"[{', '.join(map(str, range(20)))}, ...]"),
        (object, None),
    ],
)
def test_values_are_short(value: Any, text: str | None):
    """A picture as a variable would be megabytes ten times a second."""
    result = as_json(value)
    assert len(result) <= 200
    assert text is None or result == text


# ---- poses as markers ----------------------------------------------------------------------


class Sent(list[Any]):
    """A node with one publisher, which keeps what is published."""

    def create_publisher(self, *_: Any) -> Any:
        return SimpleNamespace(publish=self.append)


def goal(*places: tuple[float, float], frame: str = "map", change: str = "sent") -> GoalChanged:
    """A goal with these targets."""
    targets = tuple(NamedPose(x, y, 0.0, frame) for x, y in places)
    return GoalChanged(1, "ab", "/go", "go", 1, "active", change, targets)


def test_each_pose_is_an_arrow_with_a_number() -> None:
    """In the frame that the goal names."""
    node: Any = Sent()
    WaypointMarkers(node).take(goal((1.0, 2.0), (3.0, 4.0), frame="odom"))
    arrow, number, _, second = node[-1].markers
    assert (arrow.type, arrow.header.frame_id) == (Marker.ARROW, "odom")
    assert (arrow.pose.position.x, arrow.pose.position.y) == (1.0, 2.0)
    assert (number.text, second.text) == ("1", "2")


def test_what_is_latched_tells_of_all() -> None:
    """A goal with a new pose adds it; one without says nothing."""
    node: Any = Sent()
    topic = WaypointMarkers(node)
    topic.take(goal((1.0, 2.0)))
    topic.take(goal((1.0, 2.0)))
    topic.take(goal((9.0, 9.0), change="ended"))
    topic.take(goal())
    topic.take(goal((3.0, 4.0)))
    assert [len(message.markers) for message in node] == [2, 4]


def test_poses_without_end_are_not_all_shown() -> None:
    """They would cover the map."""
    node: Any = Sent()
    topic = WaypointMarkers(node)
    topic.take(goal(*((float(x), 0.0) for x in range(MOST + 50))))
    assert len(node[-1].markers) == 2 * MOST
