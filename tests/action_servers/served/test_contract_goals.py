"""What every action server keeps to: goals that are not accepted."""

from __future__ import annotations

import math

import pytest

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


@pytest.mark.parametrize("action", list(BAD_NUMBERS))
def test_bad_numbers_are_rejected_and_nothing_moves(bench, goal, action):
    """In every field of the goal, before acceptance; then a sound goal is accepted as usual."""
    for field, values in BAD_NUMBERS[action].items():
        for value in values:
            bad = bench.send(action, goal(action, **{field: value}))
            bench.steps(1)
            assert bad.accepted is False, (field, value)
    bench.steps(2)
    assert not bench.moved
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
    assert not bench.moved


def test_nothing_is_accepted_before_the_robot_is_heard_of(silent_bench, name):
    """No scan, no odometry: no goal."""
    sent = silent_bench.send(name)
    silent_bench.steps(3)
    assert sent.accepted is False
    assert not silent_bench.moved


@pytest.mark.parametrize("lost", ["scan", "odom"])
def test_nothing_is_accepted_when_a_sensor_has_fallen_silent(bench, name, lost):
    """An old message is no message."""
    bench.robot.silent = {lost}
    bench.steps(21)
    sent = bench.send(name)
    bench.steps(3)
    assert sent.accepted is False
    assert not bench.moved


def test_a_rejected_goal_does_not_touch_the_one_that_runs(bench, goal, name):
    """Only an accepted goal replaces another."""
    running = bench.send(name)
    bench.steps(10)
    bad = bench.send("turn", goal("turn", angle=math.nan))
    bench.steps(5)
    assert bad.accepted is False
    assert running.status is None
