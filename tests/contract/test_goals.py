"""What every action server keeps to: goals that are not accepted."""

from __future__ import annotations

import math

import pytest
from geometry_msgs.msg import Point

from action_servers.core.action import lacks_part
from tests.support.robot_node import pose
from tests.support.served import NOT_FINITE, SERVED, goal

POSE_PARTS = [("position", "x"), ("position", "y"), ("orientation", "z"), ("orientation", "w")]
FAR = (1e6, -1e6, 1e300)


def test_bad_values_are_rejected_and_nothing_moves(bench, robot, name):
    """In every field of the goal, before acceptance; then a sound goal is accepted as usual."""
    for bad_goal in SERVED[name].bad_goals(robot):
        bad = bench.send(name, bad_goal)
        bench.steps(1)
        assert bad.accepted is False, bad_goal
    bench.steps(2)
    assert not bench.moved
    sound = bench.send(name)
    bench.steps(3)
    assert sound.accepted is True


def test_every_number_of_a_goal_has_a_limit(robot, name):
    """A field that is added is not forgotten in the declaration."""
    fields = SERVED[name].type.Goal.get_fields_and_field_types()
    harmless = {"behavior_tree", "number_of_loops", "goal_index"}
    if SERVED[name].action.part:  # its `misfit` looks at lists
        parts = ("trajectory", "tolerance")
        harmless |= {field for field in fields if field.endswith(parts)}
        harmless -= {"goal_time_tolerance", "trajectory"}
    limited = {limit.field.partition(".")[0] for limit in SERVED[name].limits(robot)}
    assert limited == fields.keys() - SERVED[name].poses.keys() - harmless


@pytest.mark.parametrize("action", [name for name, first in SERVED.items() if first.poses])
def test_bad_poses_are_rejected_and_nothing_moves(bench, action):
    """Wherever in the message the number stands, and whatever the frame."""

    def refused(bad_pose):
        fields = {
            field: [pose(0.0, 0.0), bad_pose] if kind.startswith("sequence") else bad_pose
            for field, kind in SERVED[action].poses.items()
        }
        bad = bench.send(action, goal(action, **fields))
        bench.steps(1)
        return bad.accepted is False

    for outer, inner in POSE_PARTS:
        for value in NOT_FINITE:
            bad_pose = pose(1.0, 0.0)
            setattr(getattr(bad_pose.pose, outer), inner, value)
            assert refused(bad_pose), (outer, inner, value)
    stranger = pose(1.0, 0.0)
    stranger.header.frame_id = "kitchen"
    assert refused(stranger)
    bench.steps(2)
    assert not bench.moved


@pytest.mark.parametrize("action", ["backup", "drive_on_heading"])
def test_a_target_that_is_not_finite_is_rejected_and_nothing_moves(bench, action):
    """Also where the robot does not drive to it: to the side."""
    sent = bench.send(action, goal(action, target=Point(x=1.0, y=math.nan)))
    bench.steps(3)
    assert sent.accepted is False
    assert not bench.moved


@pytest.mark.parametrize("far", FAR)
def test_a_pose_outside_the_map_is_aborted_and_nothing_moves(bench, far):
    """Code 204 of Nav2's planner."""
    sent = bench.send("navigate_to_pose", goal("navigate_to_pose", pose=pose(far, 0.0)))
    bench.until(lambda: sent.status is not None, limit=10)
    assert (sent.status, sent.result.error_code) == ("aborted", 204)
    assert not bench.moved


def accepted_by(bench):
    """Return the actions of which a goal is accepted; each is cancelled before the next."""
    accepted = set()
    for name in SERVED:
        sent = bench.send(name)
        bench.steps(3)
        if sent.accepted:
            accepted.add(name)
            bench.cancel(name)
            bench.steps(2)
    return accepted


def without(sensor, robot):
    """Return the actions that do not ask for a sensor, of those that the robot can do."""
    return {
        name
        for name, served in SERVED.items()
        if sensor not in served.asks and not lacks_part(served.action, robot)
    }


def test_what_drives_is_not_accepted_before_the_robot_is_heard_of(make_bench):
    """No scan, no odometry: no goal that asks for them."""
    bench = make_bench()
    bench.robot.silent = {"scan", "odom", "tf", "camera", "joint_states"}
    bench.steps(2)
    assert accepted_by(bench) == {name for name, served in SERVED.items() if not served.asks}
    assert not bench.moved


@pytest.mark.parametrize("lost", ["scan", "odom"])
def test_nothing_is_accepted_when_a_sensor_that_it_asks_for_has_fallen_silent(bench, robot, lost):
    """An old message is no message."""
    bench.robot.silent = {lost}
    bench.steps(21)
    assert accepted_by(bench) == without(lost, robot)
    assert not bench.moved


@pytest.mark.parametrize("ray", [math.nan, 0.0])
def test_nothing_that_asks_for_a_scan_is_accepted_by_a_blind_lidar(make_bench, robot, ray):
    """All rays NaN (LDS-02) or 0 (LDS-01) say nothing: not even that the way is free."""
    bench = make_bench()
    bench.robot.rays = [ray] * 360
    bench.steps(2)
    assert accepted_by(bench) == without("scan", robot)
    assert not bench.moved
