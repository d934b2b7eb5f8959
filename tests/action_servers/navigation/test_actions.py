import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from nav2_msgs.action import FollowWaypoints, NavigateToPose

from action_servers.core.maneuver import Grid, Refusal
from action_servers.navigation import navigate, waypoints
from action_servers.navigation.actions import (
    MOST_POSES,
    plan_follow_waypoints,
    plan_navigate_through_poses,
    plan_navigate_to_pose,
)
from action_servers.robot_io.messages import fill
from bt_mission.base.geometry import Pose2D
from tests.support.fake_robot import in_the_open
from tests.support.robot_node import pose

FACING_UP = Pose2D(1.0, 1.0, math.pi / 2)
READY = in_the_open(
    10.0,
    odom=Pose2D(0.5, 0.0, 0.0),
    map_pose=FACING_UP,
    grid=Grid(0.05, -2.0, -2.0, np.zeros((80, 80), dtype=np.int8)),
)


def stamped(x=0.0, y=0.0, yaw=0.0, frame="map"):
    """A pose message."""
    message = pose(x, y, math.degrees(yaw))
    message.header.frame_id = frame
    return message


def to_pose(**fields):
    """A goal of NavigateToPose."""
    return NavigateToPose.Goal(pose=stamped(**fields))


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ({"x": 1.5, "y": 0.5, "yaw": 2.0}, (1.5, 0.5, 2.0)),
        ({"x": 1.5, "y": 0.5, "yaw": 2.0, "frame": ""}, (1.5, 0.5, 2.0)),
        ({"x": 1.5, "frame": "odom"}, (1.0, 2.0, math.pi / 2)),
        ({"x": 1.0, "yaw": 0.5, "frame": "base_link"}, (1.0, 2.0, math.pi / 2 + 0.5)),
    ],
    ids=["map", "no frame means the map", "odom", "a frame of the robot"],
)
def test_a_goal_is_moved_to_the_map(waffle, fields, expected):
    """One metre ahead of a robot that faces up is one metre up."""
    ready = replace(READY, frame_on_map={"base_link": FACING_UP}.__getitem__)
    planned = plan_navigate_to_pose(to_pose(**fields), ready, waffle)
    assert isinstance(planned, navigate.NavigateToPose)
    goal = planned._goal
    assert (goal.x, goal.y, goal.yaw) == pytest.approx(expected)


def test_a_frame_whose_place_is_not_known_is_refused(waffle):
    """With what is known of it."""
    ready = replace(READY, frame_on_map=lambda name: Refusal(f"no {name}"))
    planned = plan_navigate_to_pose(to_pose(frame="base_link"), ready, waffle)
    assert planned == Refusal("pose: no base_link")


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        (to_pose(x=math.nan), "pose must hold finite numbers, got nan, 0.0, 0.0, "),
        (to_pose(y=math.inf), "pose must hold finite numbers, got 0.0, inf, 0.0, "),
        (
            to_pose(frame="base_link"),
            "pose.header.frame_id must be one of map, odom, got 'base_link'",
        ),
        (
            NavigateToPose.Goal(behavior_tree="patrol.xml"),
            "behavior_tree must be empty, got 'patrol.xml': ",
        ),
    ],
)
def test_a_goal_that_cannot_be_meant_is_refused(waffle, goal, reason):
    """The reason says what was expected and what was got."""
    planned = plan_navigate_to_pose(goal, READY, waffle)
    assert isinstance(planned, Refusal)
    assert planned.reason.startswith(reason)


def test_an_orientation_that_is_none_is_refused(waffle):
    """A quaternion of zeros is what a forgotten field looks like."""
    goal = NavigateToPose.Goal()
    goal.pose.pose.orientation.w = 0.0
    assert plan_navigate_to_pose(goal, READY, waffle) == Refusal(
        "pose.pose.orientation must have length 1, got 0"
    )


def test_a_tour_becomes_a_maneuver(waffle):
    """With its poses, its rounds and where it begins."""
    goal = FollowWaypoints.Goal(
        number_of_loops=3, goal_index=1, poses=[stamped(1.0), stamped(0.5, 0.5, -1.0)]
    )
    planned = plan_follow_waypoints(goal, READY, waffle)
    assert isinstance(planned, waypoints.FollowWaypoints)
    assert planned._poses[1].yaw == pytest.approx(-1.0)
    assert (planned._index, planned._loops_left) == (1, 3)


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        (
            {"poses": [stamped(), stamped(frame="base_link")]},
            "poses[1].header.frame_id must be one of map, odom, got 'base_link'",
        ),
        (
            {"goal_index": 2, "poses": [stamped(), stamped()]},
            "goal_index must be from 0 to 1, got 2",
        ),
    ],
    ids=["a bad pose is named by its index", "it cannot begin behind its end"],
)
def test_a_tour_that_cannot_be_is_refused(waffle, fields, reason):
    """One fault is enough; the valid range is in the reason."""
    goal = FollowWaypoints.Goal(**fields)
    assert plan_follow_waypoints(goal, READY, waffle) == Refusal(reason)


def test_an_empty_tour_is_accepted_and_then_aborted(waffle):
    """As by Nav2; its first step says why."""
    planned = plan_follow_waypoints(FollowWaypoints.Goal(), READY, waffle)
    assert isinstance(planned, waypoints.FollowWaypoints)
    ended = planned.step(READY)
    assert getattr(ended, "error_code", None) == 600


def test_feedback_and_result_fill_nav2s_messages(waffle):
    """Every field that a maneuver names is one of the message, and of its type."""
    planned = plan_navigate_to_pose(to_pose(x=0.5), READY, waffle)
    assert isinstance(planned, navigate.NavigateToPose)
    planned.step(READY)
    stamp = NavigateToPose.Feedback().current_pose.header.stamp
    reported = fill(NavigateToPose.Feedback(), planned.feedback() or {}, lambda: stamp)
    assert reported.current_pose.pose.position.x == 1.0
    assert reported.current_pose.pose.orientation.z == pytest.approx(math.sqrt(0.5))
    assert (reported.current_pose.header.frame_id, reported.current_pose.header.stamp) == (
        "map",
        stamp,
    )
    assert reported.distance_remaining == pytest.approx(math.hypot(0.5, 1.0), abs=0.01)

    in_wall = FollowWaypoints.Goal(poses=[stamped(9.0)])
    tour = plan_follow_waypoints(in_wall, READY, waffle)
    assert isinstance(tour, waypoints.FollowWaypoints)
    tour.step(READY)
    missed = fill(FollowWaypoints.Result(), tour.result(), lambda: stamp).missed_waypoints
    assert [
        (missed_pose.index, missed_pose.goal.pose.position.x, missed_pose.error_code)
        for missed_pose in missed
    ] == [(0, 9.0, 204)]


@pytest.mark.parametrize("plan", [plan_follow_waypoints, plan_navigate_through_poses])
def test_too_many_poses_are_refused_before_any_is_looked_at(plan, fake, waffle):
    """Whatever they are."""
    goal = SimpleNamespace(poses=[None] * (MOST_POSES + 1), behavior_tree="", goal_index=0)
    planned = plan(goal, fake(waffle).observe(), waffle)
    assert planned == Refusal("poses must be 1,000 or less, got 1,001")
