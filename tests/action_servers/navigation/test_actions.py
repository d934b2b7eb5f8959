import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import FollowWaypoints, NavigateToPose

from action_servers.core.maneuver import Grid, Observation, Refusal, Scan
from action_servers.navigation import navigate, waypoints
from action_servers.navigation.actions import (
    MOST_POSES,
    plan_follow_waypoints,
    plan_navigate_through_poses,
    plan_navigate_to_pose,
)
from action_servers.robot_io.messages import fill
from bt_mission.core.geometry import Pose2D

GRID = Grid(0.05, -2.0, -2.0, np.zeros((80, 80), dtype=np.int8))
SCAN = Scan(10.0, 0.0, math.tau / 4, 0.12, 3.5, np.full(4, np.inf, dtype=np.float32))
READY = Observation(
    10.0,
    odom=Pose2D(0.5, 0.0, 0.0),
    odom_stamp_s=10.0,
    scan=SCAN,
    map_pose=Pose2D(1.0, 1.0, math.pi / 2),
    grid=GRID,
)


def stamped(x=0.0, y=0.0, yaw=0.0, frame="map"):
    """A pose message."""
    message = PoseStamped()
    message.header.frame_id = frame
    message.pose.position.x, message.pose.position.y = x, y
    message.pose.orientation.z, message.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return message


def to_pose(**fields):
    """A goal of NavigateToPose."""
    return NavigateToPose.Goal(pose=stamped(**fields))


def goal_of(maneuver):
    """Where a maneuver drives to: x, y and yaw on the map."""
    assert isinstance(maneuver, navigate.NavigateToPose)
    return maneuver._goal.x, maneuver._goal.y, maneuver._goal.yaw


@pytest.mark.parametrize("frame", ["map", ""])
def test_a_goal_on_the_map_becomes_a_maneuver(waffle, frame):
    """No frame means the map."""
    planned = plan_navigate_to_pose(to_pose(x=1.5, y=0.5, yaw=2.0, frame=frame), READY, waffle)
    assert goal_of(planned) == pytest.approx((1.5, 0.5, 2.0))


def test_a_goal_in_odom_is_moved_to_the_map(waffle):
    """One metre ahead of a robot that faces up is one metre up."""
    planned = plan_navigate_to_pose(to_pose(x=1.5, frame="odom"), READY, waffle)
    assert goal_of(planned) == pytest.approx((1.0, 2.0, math.pi / 2))


def test_a_goal_in_a_frame_of_the_robot_is_relative_to_it(waffle):
    """One metre ahead of the robot, wherever the frame has its place."""
    ready = replace(READY, frame_on_map={"base_link": Pose2D(1.0, 1.0, math.pi / 2)}.__getitem__)
    planned = plan_navigate_to_pose(to_pose(x=1.0, yaw=0.5, frame="base_link"), ready, waffle)
    assert goal_of(planned) == pytest.approx((1.0, 2.0, math.pi / 2 + 0.5))


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


def test_a_bad_pose_of_a_tour_is_named_by_its_index(waffle):
    """One fault is enough to refuse it."""
    goal = FollowWaypoints.Goal(poses=[stamped(), stamped(frame="base_link")])
    assert plan_follow_waypoints(goal, READY, waffle) == Refusal(
        "poses[1].header.frame_id must be one of map, odom, got 'base_link'"
    )


def test_a_tour_cannot_begin_behind_its_end(waffle):
    """The valid range is in the reason."""
    goal = FollowWaypoints.Goal(goal_index=2, poses=[stamped(), stamped()])
    assert plan_follow_waypoints(goal, READY, waffle) == Refusal(
        "goal_index must be from 0 to 1, got 2"
    )


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
    assert reported.current_pose.header.frame_id == "map"
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
