"""What every action server keeps to: feedback and commands."""

from __future__ import annotations

from action_servers.maneuver import ZERO


def test_feedback_comes_only_when_something_changed(bench, name):
    """At most one a control step, and never the same one twice in a row."""
    sent = bench.send(name)
    bench.steps(40)
    assert 0 < len(sent.feedback) <= 40
    if name != "follow_waypoints":  # repeats its index once a second, as a sign of life
        for one, next_one in zip(sent.feedback, sent.feedback[1:], strict=False):
            assert one != next_one


def test_idle_servers_command_nothing(bench):
    """Somebody else may drive the robot meanwhile."""
    bench.steps(40)
    assert bench.commands == []


def test_commands_come_at_the_control_rate(bench, goal):
    """One each control step until the end, and one zero at the end."""
    sent = bench.send("turn", goal("turn", angle=90.0))
    bench.until(lambda: sent.status is not None)
    count = len(bench.commands)
    bench.steps(20)
    assert len(bench.commands) == count
    assert bench.commands[-1] == ZERO
