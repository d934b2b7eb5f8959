"""What every action server of ours keeps to, whatever it does: one suite, run against each."""

from __future__ import annotations

import math
from typing import Any

import pytest
from action_msgs.srv import CancelGoal

from action_servers.camera_sweep import CameraSweep
from action_servers.explore_forward import ExploreForward
from action_servers.maneuver import ZERO, ErrorCode
from action_servers.navigation.navigate import NavigateToPose
from action_servers.navigation.waypoints import FollowWaypoints
from action_servers.turn import Turn

MANEUVERS: dict[str, Any] = {
    "explore_forward": ExploreForward,
    "turn": Turn,
    "camera_sweep": CameraSweep,
    "navigate_to_pose": NavigateToPose,
    "follow_waypoints": FollowWaypoints,
}
NOT_FINITE = (math.nan, math.inf, -math.inf)
HUGE = 3.0e38

BAD_NUMBERS: dict[str, dict[str, tuple[float, ...]]] = {
    "explore_forward": {
        "fwd_velocity": (*NOT_FINITE, 0.0, -0.2, 0.3, HUGE, -HUGE),
        "stopping_distance": (*NOT_FINITE, 0.0, -0.5, HUGE, -HUGE),
    },
    "turn": {
        "angle": (*NOT_FINITE, HUGE, -HUGE),
        "angular_velocity": (*NOT_FINITE, -1.0, 1.9, HUGE, -HUGE),
    },
    "camera_sweep": {
        "sweep_angle": (*NOT_FINITE, 0.0, -90.0, 181.0, HUGE, -HUGE),
        "image_count": (0, -1, 31, 2**31 - 1, -(2**31)),
    },
}
POSE_PARTS = [("position", "x"), ("position", "y"), ("orientation", "z"), ("orientation", "w")]


def moved(bench: Any) -> bool:
    """Whether the robot was ever told to move."""
    return any(command != ZERO for command in bench.commands)


def last_end(bench: Any) -> int:
    """Index of the last end of a goal in the events."""
    return max(i for i, event in enumerate(bench.events) if isinstance(event, tuple))


# ---- goals that are not accepted ----------------------------------------------------------------


@pytest.mark.parametrize("action", list(BAD_NUMBERS))
def test_bad_numbers_are_rejected_and_nothing_moves(bench, goal, action):
    """In every field of the goal, before acceptance; then a sound goal is accepted as usual."""
    for field, values in BAD_NUMBERS[action].items():
        for value in values:
            bad = bench.send(action, goal(action, **{field: value}))
            bench.steps(1)
            assert bad.accepted is False, (field, value)
    bench.steps(2)
    assert not moved(bench)
    sound = bench.send(action)
    bench.steps(3)
    assert sound.accepted is True


@pytest.mark.parametrize("action", ["navigate_to_pose", "follow_waypoints"])
def test_bad_poses_are_rejected_and_nothing_moves(bench, goal, pose, action):
    """Wherever in the message the number stands."""
    for outer, inner in POSE_PARTS:
        for value in NOT_FINITE:
            bad_pose = pose(1.0, 0.0)
            setattr(getattr(bad_pose.pose, outer), inner, value)
            one = action == "navigate_to_pose"
            fields = {"pose": bad_pose} if one else {"poses": [pose(0.0, 0.0), bad_pose]}
            bad = bench.send(action, goal(action, **fields))
            bench.steps(1)
            assert bad.accepted is False, (outer, inner, value)
    bench.steps(2)
    assert not moved(bench)


def test_nothing_is_accepted_before_the_robot_is_heard_of(silent_bench, name):
    """No scan, no odometry: no goal."""
    sent = silent_bench.send(name)
    silent_bench.steps(3)
    assert sent.accepted is False
    assert not moved(silent_bench)


@pytest.mark.parametrize("lost", ["scan", "odom"])
def test_nothing_is_accepted_when_a_sensor_has_fallen_silent(bench, name, lost):
    """An old message is no message."""
    bench.robot.silent = {lost}
    bench.steps(21)
    sent = bench.send(name)
    bench.steps(3)
    assert sent.accepted is False
    assert not moved(bench)


def test_a_rejected_goal_does_not_touch_the_one_that_runs(bench, goal, name):
    """Only an accepted goal replaces another."""
    running = bench.send(name)
    bench.steps(10)
    bad = bench.send("turn", goal("turn", angle=math.nan))
    bench.steps(5)
    assert bad.accepted is False
    assert running.status is None


# ---- cancel -------------------------------------------------------------------------------------


def test_cancel_stops_the_robot_before_the_result_and_at_once(bench, name):
    """Zero velocity, then the result, within the instant of the cancel."""
    sent = bench.send(name)
    bench.until(lambda: moved(bench))
    bench.steps(10)
    answer = bench.cancel(name, sent.id)
    asked_ns = bench.clock.now_ns
    bench.clock.run_until_quiet()

    assert bench.clock.now_ns == asked_ns
    assert [bytes(info.goal_id.uuid) for info in answer.result().goals_canceling] == [
        bytes(sent.id.uuid)
    ]
    assert sent.status == "canceled"
    assert (sent.result.error_code, sent.result.error_msg) == (0, "")
    assert bench.events[last_end(bench) - 1] == ZERO
    bench.steps(10)
    assert bench.events[last_end(bench) :] == [(sent.name, "canceled")]
    assert abs(bench.robot.fake.linear) + abs(bench.robot.fake.angular) < 1e-6


def test_a_goal_that_is_canceled_with_its_arrival_ends_canceled(bench, name):
    """Goal and cancel wait side by side when the server looks: execution has not begun."""
    sent = bench.send(name)
    answer = bench.cancel(name, sent.id)
    bench.steps(3)
    assert len(answer.result().goals_canceling) == 1
    assert (sent.accepted, sent.status) == (True, "canceled")
    assert not moved(bench)


def test_cancel_after_the_end_changes_nothing(bench, goal):
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
    """The goal that runs goes on."""
    sent = bench.send(name)
    bench.steps(5)
    stranger = type(sent.id)(uuid=[99] * 16)
    answer = bench.cancel(name, stranger)
    bench.steps(5)
    assert answer.result().return_code == CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID
    assert sent.status is None


def test_cancel_of_all_goals(bench, name):
    """An empty id means every goal of the server."""
    sent = bench.send(name)
    bench.steps(5)
    answer = bench.cancel(name)
    bench.steps(1)
    assert len(answer.result().goals_canceling) == 1
    assert sent.status == "canceled"


def test_a_second_cancel_changes_nothing(bench, name):
    """However often it is asked for."""
    sent = bench.send(name)
    bench.steps(5)
    answers = [bench.cancel(name, sent.id) for _ in range(3)]
    bench.steps(3)
    assert all(answer.done() for answer in answers)
    assert sent.status == "canceled"
    assert bench.events.count((sent.name, "canceled")) == 1


# ---- replacement --------------------------------------------------------------------------------


@pytest.mark.parametrize("newer", list(MANEUVERS))
def test_a_new_goal_of_any_server_replaces_the_one_that_runs(bench, name, newer):
    """The old goal ends aborted, with the robot stopped in between; the new one drives on."""
    old = bench.send(name)
    bench.until(lambda: moved(bench))
    new = bench.send(newer, client=1)
    bench.until(lambda: old.status is not None, limit=2)
    assert old.status == "aborted"
    assert old.result.error_code == ErrorCode.STOPPED
    assert old.result.error_msg == "replaced by a new goal"
    assert bench.events[last_end(bench) - 1] == ZERO
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


# ---- faults -------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["step", "feedback"])
def test_a_maneuver_that_raises_ends_its_goal_and_not_the_server(bench, name, method, monkeypatch):
    """Aborted with the cause, the robot stopped, the next goal as usual."""
    sent = bench.send(name)
    bench.until(lambda: moved(bench))
    bench.steps(5)

    def broken(*_: Any) -> None:
        raise KeyError("no such sensor")

    with monkeypatch.context() as patch:
        patch.setattr(MANEUVERS[name], method, broken)
        bench.steps(2)
    assert sent.status == "aborted"
    assert sent.result.error_code == ErrorCode.UNKNOWN
    assert sent.result.error_msg == "KeyError: 'no such sensor'"
    assert bench.events[last_end(bench) - 1] == ZERO

    following = bench.send(name)
    bench.steps(20)
    assert (following.accepted, following.status) == (True, None)
    assert bench.commands[-1] != ZERO


def test_a_result_that_raises_still_ends_the_goal(bench, name, monkeypatch):
    """The client is not left waiting."""
    sent = bench.send(name)
    bench.steps(5)

    def broken(*_: Any) -> None:
        raise KeyError("no such sensor")

    with monkeypatch.context() as patch:
        patch.setattr(MANEUVERS[name], "result", broken)
        bench.cancel(name, sent.id)
        bench.steps(1)
    assert sent.status == "canceled"


@pytest.mark.parametrize("method", ["feedback", "result"])
def test_fields_that_do_not_exist_end_the_goal_and_not_the_server(bench, goal, method, monkeypatch):
    """The reason lists the fields that there are."""
    with monkeypatch.context() as patch:
        patch.setattr(Turn, method, lambda *_: {"angel": 1.0})
        sent = bench.send("turn", goal("turn", angle=5.0))
        bench.until(lambda: sent.status is not None)
    assert sent.status == "aborted"
    assert sent.result.error_code == ErrorCode.UNKNOWN
    assert "has no field 'angel', only" in sent.result.error_msg


@pytest.mark.parametrize("lost", ["scan", "odom"])
def test_a_sensor_that_falls_silent_ends_the_goal(bench, name, lost):
    """Within five seconds, aborted with a code and a reason, and the robot stands."""
    sent = bench.send(name)
    bench.until(lambda: moved(bench))
    bench.robot.silent = {lost}
    bench.until(lambda: sent.status is not None, limit=100)
    assert sent.status == "aborted"
    assert sent.result.error_code != 0
    assert sent.result.error_msg != ""
    assert bench.events[last_end(bench) - 1] == ZERO


# ---- the end of the servers ---------------------------------------------------------------------


def test_stopping_the_servers_ends_the_goal_with_the_robot_stopped(bench, name):
    """And nothing is accepted any more."""
    sent = bench.send(name)
    bench.until(lambda: moved(bench))
    bench.servers.stop("the action servers were stopped by SIGTERM")
    bench.clock.run_until_quiet()
    assert sent.status == "aborted"
    assert sent.result.error_msg == "the action servers were stopped by SIGTERM"
    assert bench.commands[-1] == ZERO
    late = bench.send(name)
    bench.steps(5)
    assert late.accepted is False
    assert bench.commands[-1] == ZERO


def test_destroying_the_node_stops_the_robot(bench, name):
    """Even when nobody waits for a result."""
    bench.send(name)
    bench.until(lambda: moved(bench))
    bench.servers.destroy_node()
    bench.clock.remove_node(bench.servers)
    bench.steps(1)
    assert bench.commands[-1] == ZERO


# ---- feedback and commands ----------------------------------------------------------------------


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
