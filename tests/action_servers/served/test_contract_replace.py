"""What every action server keeps to: a new goal replaces the one that runs."""

from __future__ import annotations

from action_servers.maneuver import ZERO, ErrorCode


def test_a_new_goal_of_any_server_replaces_the_one_that_runs(bench, name, newer):
    """The old goal ends aborted, with the robot stopped in between; the new one drives on."""
    old = bench.send(name)
    bench.until(lambda: bench.moved)
    new = bench.send(newer, client=1)
    bench.until(lambda: old.status is not None, limit=2)
    assert old.status == "aborted"
    assert old.result.error_code == ErrorCode.STOPPED
    assert old.result.error_msg == "replaced by a new goal"
    assert bench.before_the_last_end == ZERO
    bench.steps(30)
    assert (new.accepted, new.status) == (True, None)
    assert bench.commands[-1] != ZERO


def test_a_burst_of_goals_leaves_the_last_one_running(bench, name):
    """All are accepted, all but the last end aborted, each exactly once."""
    sent = [bench.send(name, client=number % 2) for number in range(6)]
    bench.steps(10)
    assert [goal.accepted for goal in sent] == [True] * 6
    running = [goal for goal in sent if goal.status is None]
    assert len(running) == 1
    ends = [event for event in bench.events if isinstance(event, tuple)]
    assert sorted(ends) == sorted((goal.name, "aborted") for goal in sent if goal is not running[0])
    assert bench.commands[-1] == bench.robot.command


def test_feedback_belongs_to_its_goal(bench, name):
    """Two clients hear each of their own goal alone, and none after its end."""
    first = bench.send(name, client=0)
    bench.steps(25)
    heard = len(first.feedback)
    second = bench.send(name, client=1)
    bench.until(lambda: first.status is not None, limit=3)
    at_the_end = len(first.feedback)
    bench.steps(25)
    assert heard > 0
    assert len(first.feedback) == at_the_end
    assert len(second.feedback) > 0


def test_a_goal_id_is_used_once(bench, name):
    """A second goal with the id of one that runs is rejected, and the first goes on."""
    first = bench.send(name)
    bench.steps(5)
    bench._sent -= 1
    second = bench.send(name)
    bench.steps(5)
    assert second.accepted is False
    assert first.status is None
