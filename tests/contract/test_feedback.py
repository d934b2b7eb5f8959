"""What every action server keeps to: feedback and commands."""

from __future__ import annotations

from itertools import pairwise

from action_servers.core.maneuver import ZERO
from tests.support.served import SERVED, goal

# Repeats what it last told once a second, as a sign of life.
SIGN_OF_LIFE = {"follow_waypoints", "explore_frontiers"}
# A picture that shows the same as the last, and a distance that has not grown, are news.
EACH_IS_NEWS = {"find_colour", "record_distance"}


def test_feedback_comes_only_when_something_changed(bench, name):
    """At most one a control step, and never the same one twice in a row."""
    sent = bench.send(name)
    bench.steps(60)
    assert 0 < len(sent.feedback) <= 60
    if name not in SIGN_OF_LIFE | EACH_IS_NEWS:
        for first, next_one in pairwise(sent.feedback):
            assert first != next_one


def test_feedback_stays_within_the_declared_ranges(bench, name):
    """By which `check` knows conditions that never hold."""
    sent = bench.send(name)
    bench.steps(200)
    ranges = SERVED[name].action.feedback(goal(name))
    assert sent.feedback
    for field, (low, high) in ranges.items():
        values = [getattr(message, field) for message in sent.feedback]
        assert low <= min(values), field
        assert max(values) <= high, field


def test_idle_servers_command_nothing(bench):
    """Somebody else may drive the robot meanwhile."""
    bench.steps(40)
    assert bench.commands == []


def test_commands_come_at_the_control_rate(bench):
    """One each control step until the end, and one zero at the end."""
    sent = bench.send("turn", goal("turn", angle=90.0))
    bench.until(lambda: sent.status is not None)
    count = len(bench.commands)
    bench.steps(20)
    assert len(bench.commands) == count
    assert bench.commands[-1] == ZERO
