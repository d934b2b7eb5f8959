"""What every action server keeps to: a goal that comes while another one runs."""

from __future__ import annotations

import math

import pytest

from action_servers.core.maneuver import ZERO, ErrorCode
from action_servers.core.pilot import REFUSED_WHILE_DRIVING
from bt_mission.base.goal_rate import MOST_GOALS
from tests.support.served import BESIDE, DRIVING, OF_PARTS, SERVED, goal
from tests.support.thorough import sample

PAIRS = [
    (old, new)
    for shift in (0, 4)
    for old, new in zip(DRIVING, DRIVING[shift:] + DRIVING[:shift], strict=True)
]


@pytest.mark.parametrize(("old_name", "new_name"), sample(PAIRS, 3))
def test_a_new_goal_of_any_server_replaces_the_one_that_drives(bench, old_name, new_name):
    """The old goal ends aborted, with the robot stopped in between; the new one drives on."""
    old = bench.send(old_name)
    bench.until(lambda: bench.moved)
    new = bench.send(new_name, client=1)
    bench.until(lambda: old.status is not None, limit=2)
    assert old.status == "aborted"
    assert old.result.error_code == ErrorCode.STOPPED
    assert old.result.error_msg.startswith("replaced by a new goal: ")
    assert bench.before_the_last_end == ZERO
    bench.steps(30)
    assert (new.accepted, new.status) == (True, None)
    assert bench.commands[-1] != ZERO


def test_a_new_goal_is_refused_where_that_is_the_rule(make_bench, driving):
    """With on_new_goal: refuse, the first continues; after its end the next is accepted."""
    bench = make_bench(on_new_goal="refuse")
    bench.steps(2)
    old = bench.send(driving)
    bench.until(lambda: bench.moved)
    new = bench.send("turn", client=1)
    bench.steps(5)
    assert (old.status, new.accepted) == (None, False)
    assert bench.servers.why_rejected("/turn") == REFUSED_WHILE_DRIVING
    bench.cancel(driving, old.id)
    bench.steps(2)
    following = bench.send("turn", client=1)
    bench.steps(2)
    assert following.accepted is True


def test_what_does_not_drive_runs_beside_what_does(bench, beside):
    """Neither ends the other, and it commands nothing itself."""
    aside = bench.send(beside)
    bench.steps(10)
    assert bench.commands == []
    drive = bench.send("turn", client=1)
    bench.steps(10)
    again = bench.send(beside, client=1)
    bench.steps(10)
    assert [sent.status for sent in (aside, drive, again)] == [None] * 3
    assert ZERO not in bench.commands
    assert len(bench.commands) >= 19


@pytest.mark.parametrize("name", OF_PARTS)
@pytest.mark.parametrize("rule", ["replace", "refuse"])
def test_one_goal_at_a_time_moves_a_part(make_bench, name, rule):
    """A new one replaces it or is refused, the joints stop at a cancel, and the base may drive."""
    bench = make_bench(on_new_goal=rule)
    bench.steps(2)
    drive, old = bench.send("turn"), bench.send(name)
    bench.steps(10)
    new = bench.send(name, client=1)
    bench.steps(5)
    statuses = {"replace": ("aborted", True), "refuse": (None, False)}
    assert (old.status, new.accepted) == statuses[rule]
    assert drive.status is None
    bench.cancel(name)
    bench.steps(2)
    last = bench.robot.joint_commands[-1]
    where = dict(bench.robot.joints)
    assert dict(zip(last.name, last.position, strict=True)).items() <= where.items()
    bench.steps(10)
    assert bench.robot.joints == where
    following = bench.send(name)
    bench.steps(2)
    assert following.accepted is True


def test_goals_that_do_not_drive_are_limited_in_number(make_bench, beside):
    """Each keeps memory; the one too many is refused, and a place that is left is given away."""
    bench = make_bench(side_goals=3)
    bench.steps(2)
    sent = [bench.send(beside) for _ in range(4)]
    bench.steps(3)
    assert [goal.accepted for goal in sent] == [True, True, True, False]
    bench.cancel(beside, sent[0].id)
    bench.steps(2)
    following = bench.send(beside)
    bench.steps(2)
    assert following.accepted is True


@pytest.mark.parametrize("name", sample(SERVED, every=5))
def test_goals_in_a_burst_end_each_exactly_once(bench, name):
    """From two clients at one instant; each is answered.

    At the end runs what may run, and ten seconds later the server takes the next goal as usual.
    One server gets more than it accepts in that time, the others fewer, since each end is sent to
    all clients.
    """
    count = 2 * MOST_GOALS if name == "turn" else 60
    sent = [bench.send(name, client=number % 2) for number in range(count)]
    bench.steps(5)
    messages = [goal for goal in sent if goal.accepted is not None]
    refused = [message for message in messages if not message.accepted]
    running = [message for message in messages if message.accepted and message.status is None]
    most = 1 if SERVED[name].is_alone else 8
    accepted = min(count, MOST_GOALS) if SERVED[name].is_alone else most
    assert len(messages) == count
    assert len(running) == most
    assert len(refused) == count - accepted
    ends = [event for event in bench.events if isinstance(event, tuple)]
    assert len(ends) == len(set(ends)) == len(messages) - len(refused) - len(running)
    bench.cancel(name)
    bench.steps(200)
    following = bench.send(name)
    bench.steps(2)
    assert following.accepted is True


def test_feedback_belongs_to_its_goal(bench, name):
    """Two clients hear each of their own goal alone, and none after its end."""
    first = bench.send(name, client=0)
    bench.steps(25)
    received = len(first.feedback)
    second = bench.send(name, client=1)
    if name in BESIDE:
        bench.steps(1)
        bench.cancel(name, first.id)
    bench.until(lambda: first.status is not None, limit=3)
    at_the_end = len(first.feedback)
    bench.steps(25)
    assert received > 0
    assert len(first.feedback) == at_the_end
    assert len(second.feedback) > 0


def test_a_rejected_goal_does_not_touch_the_one_that_runs(bench, name):
    """Only an accepted goal replaces another; a goal with the id of a running one is rejected."""
    first = bench.send(name)
    bench.steps(5)
    bench.repeat_the_last_id()
    second = bench.send(name)
    bad = bench.send("turn", goal("turn", angle=math.nan))
    bench.steps(5)
    assert (second.accepted, bad.accepted) == (False, False)
    assert first.status is None
