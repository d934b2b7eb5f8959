"""A server rejects more goals than it can handle, and continues."""

from __future__ import annotations

from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from bt_mission_interfaces.action import Turn
from rclpy.qos import QoSProfile

from action_servers.core.maneuver import ZERO
from bt_mission.base.action_requests import MOST_RESULT_REQUESTS
from bt_mission.base.goal_rate import MOST_GOALS

PERIOD_NS = 50_000_000
MANY = 300


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["turn"])
def test_goals_beyond_the_limit_are_rejected_at_once(bench: Any, name: str) -> None:
    """Each with an answer; after ten seconds goals are accepted again."""
    sent = []
    for _ in range(MOST_GOALS // 10 + 2):
        sent += [bench.send(name) for _ in range(10)]
        bench.steps(1)
    assert [goal.accepted for goal in sent] == [True] * MOST_GOALS + [False] * 20
    assert "within 10 s, which is the limit" in bench.servers.why_rejected(f"/{name}")
    assert len(bench.commands) >= MOST_GOALS // 10
    bench.steps(200)
    again = bench.send(name)
    bench.steps(2)
    assert again.accepted is True


def test_each_of_many_goals_that_cannot_be_is_rejected(bench: Any) -> None:
    """They count for nothing: a sound goal is accepted among them."""
    wrong = [bench.send("turn", Turn.Goal(angle=float("nan"))) for _ in range(MANY)]
    sound = bench.send("turn")
    bench.steps(1)
    assert [goal.accepted for goal in wrong] == [False] * MANY
    assert sound.accepted is True


def test_each_of_many_cancels_is_answered(bench: Any) -> None:
    """Of a goal once, of none after that; the goal ends once."""
    sent = bench.send("turn")
    bench.steps(3)
    answers = [bench.cancel("turn") for _ in range(MANY)]
    bench.steps(2)
    assert all(answer.done() for answer in answers)
    assert sum(len(answer.result().goals_canceling) for answer in answers) == 1
    assert sent.status == "canceled"
    assert len([event for event in bench.events if isinstance(event, tuple)]) == 1


def test_each_of_many_stops_is_answered_and_commands_zero(bench: Any) -> None:
    """The last thing that the base hears is to stand, and one release is enough."""
    sent = bench.send("turn")
    bench.steps(3)
    answers = [bench.trigger("stop") for _ in range(MANY)]
    bench.steps(2)
    assert all(answer.done() and answer.result().success for answer in answers)
    assert sent.status == "aborted"
    assert bench.commands[-1] == ZERO
    released = bench.trigger("release")
    again = bench.send("turn")
    bench.steps(2)
    assert released.result().message == "released"
    assert again.accepted is True


def test_so_many_requests_for_one_result_wait(bench: Any) -> None:
    """More are answered at once, with the status unknown; the others when the goal ends."""
    sent = bench.send("turn")
    bench.steps(2)
    service = Turn.Impl.GetResultService
    deep = QoSProfile(depth=2 * MOST_RESULT_REQUESTS)
    name = "turn/_action/get_result"
    client = bench.clients[0].create_client(service, name, qos_profile=deep)
    more = 20
    asked = [
        client.call_async(service.Request(goal_id=sent.id))
        for _ in range(MOST_RESULT_REQUESTS + more)
    ]
    bench.clock.run_until_quiet()
    refused = [answer for answer in asked if answer.done()]
    # The client of the goal itself has asked first.
    assert [answer.result().status for answer in refused] == [0] * (more + 1)
    bench.cancel("turn")
    bench.steps(2)
    assert {answer.result().status for answer in asked if answer not in refused} == {
        GoalStatus.STATUS_CANCELED
    }


@pytest.mark.thorough
def test_each_control_step_is_made_between_requests(bench: Any) -> None:
    """A driving goal continues while others are rejected."""
    driving = bench.send("turn")
    bench.steps(2)
    first = len(bench.commands)
    for _ in range(10):
        for _ in range(MANY // 10):
            bench.send("move")
            bench.cancel("wait")
        bench.steps(1)
    assert driving.status == "aborted"  # replaced by the first of the others
    assert len(bench.commands) - first >= 10


def test_a_clock_that_is_set_back_again_and_again_ends_the_goal_once(bench: Any) -> None:
    """Nothing moves after that until another goal comes."""
    sent = bench.send("turn")
    bench.steps(3)
    clock = bench.clock
    for _ in range(MANY // 2):
        clock.clocks.set_ahead(bench.servers, -2 * PERIOD_NS, clock.now_ns)
        bench.steps(1)
    assert sent.status == "aborted"
    assert "the ROS clock was set back" in sent.result.error_msg
    ended = bench.events.index((sent.name, "aborted"))
    assert all(event == ZERO for event in bench.events[ended + 1 :])
