"""What reaches the goals of a mission besides the answers of their servers."""

from __future__ import annotations

import random
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest
from action_msgs.msg import GoalStatusArray
from bt_mission_interfaces.action import Turn
from rcl_interfaces.msg import Log
from rclpy.action import ActionServer
from rclpy.serialization import serialize_message

from bt_mission.ros.graph import LATCHED

TURN = "mission: m\ntree:\n  turn: {angle: 90}\n  timeout: 9\n"
LOOP = """\
mission: m
tree:
  retry: {attempts: 2}
  do: {turn: {angle: 90}, timeout: 9}
"""


@pytest.fixture
def warn(ros: Any) -> Callable[..., None]:
    """Somebody warns, or logs something else."""
    publisher = ros.client.create_publisher(Log, "/rosout", 10)

    def log(name: str, text: str, level: int = Log.WARN) -> None:
        publisher.publish(Log(level=level, name=name, msg=text))

    return log


def test_the_reason_reaches_the_leaf(ros: Any, warn: Callable[[str, str], None]) -> None:
    """That of its own server, at the tick that hears of the rejection."""
    server = ros.server(accepts=None)
    node = ros.mission(TURN)
    began = ros.until(lambda: server.goals)
    warn("other", "not mine")
    warn("turn_server.turn", "goal rejected: angle: too\x1b[31m large")
    server.goal.reject()
    ended = ros.until(lambda: node.is_done)
    assert node.executive.reason == "'turn' rejected: /turn: angle: too\x1b[31m large"
    assert ended - began == pytest.approx(0.05)


def test_words_may_come_after_the_answer(ros: Any, warn: Callable[[str, str], None]) -> None:
    """Until the leaf is ticked."""
    server, node = ros.turning(TURN, accepts=None)
    server.goal.reject()
    ros.run(0.0)
    warn("turn_server", "not today")
    ros.until(lambda: node.is_done)
    assert node.executive.reason == "'turn' rejected: /turn: not today"


def test_words_of_before_the_goal_do_not_count(ros: Any, warn: Callable[[str, str], None]) -> None:
    """A server that gives no reason is said to have given none."""
    server, node = ros.turning(LOOP, accepts=None)
    warn("turn_server", "not today")
    server.goal.reject()
    ros.until(lambda: len(server.goals) == 2)
    assert "rejected: /turn: not today" in [change.message for change in ros.changes]
    server.goal.reject()
    ros.until(lambda: node.is_done)
    assert node.executive.reason == "'turn' rejected: /turn: its server gave no reason"


def test_a_line_that_is_no_warning_is_marked(ros: Any, warn: Callable[..., None]) -> None:
    """A warning takes precedence; lines of others do not count."""
    server, node = ros.turning(LOOP, accepts=None)
    for name, text in (("turn_server", "battery low"), ("other", "hello")):
        warn(name, text, Log.INFO)
    server.goal.reject()
    ros.until(lambda: len(server.goals) == 2)
    warn("turn_server", "not today")
    warn("turn_server", "battery low", Log.INFO)
    server.goal.reject()
    ros.until(lambda: node.is_done)
    rejected = [change.message for change in ros.changes if "rejected" in change.message]
    assert rejected == ["rejected: /turn: logged 'battery low'", "rejected: /turn: not today"]


def test_an_action_with_two_servers_gets_no_goal(ros: Any) -> None:
    """Both are named. One of them may be the rest of a process that was killed."""
    first, second = ros.server(), ros.server("other")
    other = ActionServer(second.node, Turn, "turn", lambda _: None)
    node = ros.mission(LOOP)
    ros.until(lambda: len(ros.changes) > 2)
    assert (
        "server not available: /turn has 2 servers (/other_server, /turn_server): each of them "
        "runs every goal; stop one, or give each its own namespace or ROS_DOMAIN_ID (a killed "
        "process is listed for up to 20 s) after 5 s"
    ) in [change.message for change in ros.changes]
    assert node.executive.goals_sent == 0
    other.destroy()
    ros.until(lambda: first.goals)
    first.goal.succeed()
    ros.until(lambda: node.is_done)
    assert node.executive.reason == ""


def test_a_second_server_that_may_be_there_is_named_in_the_report(ros: Any) -> None:
    """Once, however many goals are sent."""
    first, second = ros.server(), ros.server("other")
    silent: Any = {"handle_accepted_callback": lambda _: None}
    other = ActionServer(second.node, Turn, "turn", lambda _: None, **silent)
    node = ros.mission(LOOP, allow_duplicates=True)
    ros.until(lambda: first.goals)
    (warning,) = node.report().warnings
    assert warning.startswith("/turn has 2 servers (/other_server, /turn_server): each of them ")
    assert f"  warning: {warning}" in str(node.report())
    other.destroy()


def spoilt(rng: random.Random, data: bytes) -> bytes:
    """Return a message cut, with more behind it, with other bytes in it, or noise."""
    match rng.randrange(4):
        case 0:
            return data[: rng.randrange(4, len(data))]
        case 1:
            return data + rng.randbytes(20)
        case 2:
            at = rng.randrange(len(data))
            return data[:at] + rng.randbytes(4) + data[at + 4 :]
    return rng.randbytes(40)


def test_malformed_feedback_and_statuses_harm_no_goal(ros: Any) -> None:
    """They come from anybody; the goal goes on, and what its server says counts."""
    turn, mission = ros.turning(TURN.replace("timeout: 9", "timeout: 600"))
    feedback = ros.client.create_publisher(Turn.Impl.FeedbackMessage, "/turn/_action/feedback", 10)
    statuses = ros.client.create_publisher(GoalStatusArray, "/turn/_action/status", LATCHED)
    ros.run(0.5)
    assert (feedback.get_subscription_count(), statuses.get_subscription_count()) == (1, 1)
    rng = random.Random(1)
    for _ in range(100):
        for publisher, kind in ((feedback, Turn.Impl.FeedbackMessage), (statuses, GoalStatusArray)):
            with suppress(Exception):  # what DDS itself refuses to send
                publisher.publish(spoilt(rng, serialize_message(kind())))
        ros.run(0.05)
    assert mission.executive.mission_state.status == "running"
    assert [goal.feedback for goal in mission.ledger.open_goals] == [None]
    turn.goal.feed(current_angle=12.0)
    ros.run(0.5)
    angles = [goal.feedback.current_angle for goal in mission.ledger.open_goals]
    assert angles == pytest.approx([12.0])
    turn.goal.succeed()
    ros.until(lambda: mission.executive.is_done)
    assert mission.executive.mission_state.status == "success"
