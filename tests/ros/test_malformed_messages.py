"""What is sent on the topics of an action without being a message of it harms no mission."""

from __future__ import annotations

import random
from contextlib import suppress
from typing import Any

import pytest
from action_msgs.msg import GoalStatusArray
from bt_mission_interfaces.action import Turn
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message

MISSION = "mission: m\ntree:\n  turn: {angle: 90}\n  timeout: 600\n"
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


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
    turn = ros.server()
    mission = ros.mission(MISSION)
    ros.until(lambda: turn.goals)
    feedback = ros.client.create_publisher(Turn.Impl.FeedbackMessage, "/turn/_action/feedback", 10)
    statuses = ros.client.create_publisher(GoalStatusArray, "/turn/_action/status", LATCHED)
    ros.run(0.5)
    assert (feedback.get_subscription_count(), statuses.get_subscription_count()) == (1, 1)
    rng = random.Random(1)
    for _ in range(100):
        for publisher, kind in (
            (feedback, Turn.Impl.FeedbackMessage),
            (statuses, GoalStatusArray),
        ):
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
