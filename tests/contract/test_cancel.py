"""What every action server keeps to: goals that are canceled."""

from __future__ import annotations

from action_msgs.srv import CancelGoal

from action_servers.core.maneuver import ZERO
from tests.support.served import SERVED, goal


def test_cancel_ends_the_goal_within_the_instant(bench, name):
    """With the robot stopped before the result, if the goal drives."""
    sent = bench.send(name)
    if SERVED[name].drives:
        bench.until(lambda: bench.moved)
    bench.steps(10)
    answer = bench.cancel(name, sent.id)
    asked_ns = bench.clock.now_ns
    bench.clock.run_until_quiet()

    assert bench.clock.now_ns == asked_ns
    assert [bytes(info.goal_id.uuid) for info in answer.result().goals_canceling] == [
        bytes(sent.id.uuid)
    ]
    assert sent.status == "canceled"
    assert (sent.code, sent.text) in ((0, ""), (None, None))
    if SERVED[name].drives:
        assert bench.before_the_last_end == ZERO
    bench.steps(10)
    assert bench.events[-1] == (sent.name, "canceled")
    assert abs(bench.robot.fake.linear) + abs(bench.robot.fake.angular) < 1e-6


def test_a_goal_that_is_canceled_with_its_arrival_ends_canceled(bench, name):
    """Goal and cancel wait side by side when the server looks: execution has not begun."""
    sent = bench.send(name)
    answer = bench.cancel(name, sent.id)
    bench.steps(3)
    assert len(answer.result().goals_canceling) == 1
    assert (sent.accepted, sent.status) == (True, "canceled")
    assert not bench.moved


def test_cancel_after_the_end_changes_nothing(bench):
    """The answer says that the goal had ended; nothing is commanded any more."""
    sent = bench.send("turn", goal("turn", angle=10.0))
    bench.until(lambda: sent.status is not None)
    before = list(bench.events)
    answer = bench.cancel("turn", sent.id)
    bench.steps(5)
    assert answer.result().return_code == CancelGoal.Response.ERROR_GOAL_TERMINATED
    assert bench.events == before
    assert sent.status == "succeeded"


def test_cancel_of_an_unknown_goal_changes_nothing(bench, name):
    """The running goal continues."""
    sent = bench.send(name)
    bench.steps(5)
    stranger = type(sent.id)(uuid=[99] * 16)
    answer = bench.cancel(name, stranger)
    bench.steps(5)
    assert answer.result().return_code == CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID
    assert sent.status is None


def test_cancel_of_all_goals_and_often(bench, name):
    """An empty id means every goal of the server; a second cancel changes nothing."""
    sent = bench.send(name)
    bench.steps(5)
    answers = [bench.cancel(name) for _ in range(3)]
    bench.steps(3)
    assert all(answer.done() for answer in answers)
    assert len(answers[0].result().goals_canceling) == 1
    assert sent.status == "canceled"
    assert bench.events.count((sent.name, "canceled")) == 1
