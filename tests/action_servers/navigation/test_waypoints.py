import dataclasses

import pytest

from action_servers.core.maneuver import SUCCEEDED, Finished
from action_servers.core.tuning import NavigationTuning
from action_servers.navigation.waypoints import FollowWaypoints
from bt_mission.core.geometry import Pose2D

ROOM = """
    ############
    #..........#
    #..........#
    #..........#
    #..........#
    #..R.......#
    #..........#
    #..........#
    #..........#
    ############
"""
LEFT, RIGHT, TOP = Pose2D(0.7, 0.9, 1.0), Pose2D(1.5, 0.7, 0.0), Pose2D(1.3, 1.3, -2.0)
IN_WALL = Pose2D(0.1, 0.1, 0.0)


@pytest.fixture
def tour(waffle, world, robot_in):
    """Drive a tour; return the robot, the maneuver and what it told."""

    def run(poses, **options):
        robot = robot_in(world(ROOM))
        maneuver = FollowWaypoints(poses, waffle, **options)
        reports = []

        def listen(robot):
            fields = maneuver.feedback()
            if fields is not None:
                reports.append((round(robot.time_s, 2), fields["current_waypoint"]))

        robot.run(maneuver, 200.0, listen)
        return robot, maneuver, reports

    return run


def order(reports):
    """The waypoints in the order in which they were driven to."""
    indices = [index for _, index in reports]
    return [index for k, index in enumerate(indices) if k == 0 or index != indices[k - 1]]


def test_poses_are_visited_in_turn(tour):
    """And it stands at the last one, turned as asked."""
    robot, maneuver, reported = tour([RIGHT, TOP, LEFT])
    assert robot.finished == SUCCEEDED
    assert order(reported) == [0, 1, 2]
    assert robot.distance_to(LEFT) < 0.05
    assert robot.pose.yaw == pytest.approx(LEFT.yaw, abs=0.03)
    assert maneuver.result() == {"missed_waypoints": []}
    for pose in (RIGHT, TOP):
        nearest = min(
            dataclasses.replace(robot, pose=passed).distance_to(pose)
            for _, passed, _ in robot.trace
        )
        assert nearest < 0.05


def test_loops_are_rounds_after_the_first(tour):
    """As in Nav2, where 0 is one round."""
    _, _, reported = tour([RIGHT, LEFT], loops=1)
    assert order(reported) == [0, 1, 0, 1]


def test_it_can_begin_in_the_middle(tour):
    """Later rounds begin at 0 all the same."""
    _, _, reported = tour([RIGHT, TOP, LEFT], first=2, loops=1)
    assert order(reported) == [2, 0, 1, 2]


def test_a_pose_that_cannot_be_reached_ends_the_tour(tour):
    """It is named with its index and the code of navigation."""
    robot, maneuver, reported = tour([RIGHT, IN_WALL, LEFT])
    assert robot.finished.status == "aborted"
    assert robot.finished.error_code == 600
    assert robot.finished.reason.startswith(
        "waypoint 1 (of 0 to 2) was not reached, code 206: the robot does not fit at the goal"
    )
    assert maneuver.result() == {
        "missed_waypoints": [{"index": 1, "goal": IN_WALL, "error_code": 206}]
    }
    assert order(reported) == [0, 1]


def test_it_can_go_on_after_a_pose_that_was_missed(tour):
    """The tour succeeds, and the result says what was left out."""
    robot, maneuver, _ = tour(
        [IN_WALL, RIGHT, IN_WALL], tuning=NavigationTuning(stop_on_failure=False)
    )
    assert robot.finished == SUCCEEDED
    assert [missed["index"] for missed in maneuver.result()["missed_waypoints"]] == [0, 2]
    assert robot.distance_to(RIGHT) < 0.05


def test_no_poses_are_no_tour(tour):
    """Nav2 aborts such a goal too."""
    robot, maneuver, reported = tour([])
    assert robot.finished == Finished("aborted", 600, "the list of poses is empty")
    assert reported == []
    assert maneuver.result() == {"missed_waypoints": []}


def test_feedback_comes_on_change_and_once_a_second(tour):
    """A sign of life for who watches for silence, without twenty messages a second.

    The times are those of the step after.
    """
    _, _, reported = tour([RIGHT])
    assert reported[:3] == [(10.05, 0), (11.05, 0), (12.05, 0)]
