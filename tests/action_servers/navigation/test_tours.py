"""Facts about driving past poses to the last one, and from waypoint to waypoint."""

from __future__ import annotations

import dataclasses
import math
from itertools import groupby

import pytest

from action_servers.core.maneuver import SUCCEEDED, Finished
from action_servers.navigation.path import NavigationTuning
from action_servers.navigation.surroundings import Surroundings
from action_servers.navigation.waypoints import FollowWaypoints, NavigateThroughPoses
from bt_mission.base.geometry import Pose2D
from tests.support.thorough import sample

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
AHEAD, FURTHER = Pose2D(1.2, 0.9, 2.5), Pose2D(1.7, 0.9, 0.0)
IN_WALL = Pose2D(0.1, 0.1, 0.0)


@pytest.fixture
def drive(waffle, world, robot_in):
    """Drive a maneuver in the room; return the robot, and what was told when, at which speed."""

    def run(maneuver):
        robot = robot_in(world(ROOM))
        reports = []

        def listen(robot):
            reports.append((round(robot.time_s, 2), robot.linear, maneuver.feedback()))

        robot.drive(maneuver, 200.0, listen)
        return robot, reports

    return run


@pytest.fixture
def through(waffle, drive):
    """Drive through poses; return the robot, its speeds, and the feedback."""

    def run(*poses):
        robot, reports = drive(NavigateThroughPoses(poses, waffle, Surroundings(waffle)))
        speeds = [speed for _, speed, _ in reports]
        return robot, speeds, [fields for _, _, fields in reports if fields is not None]

    return run


@pytest.fixture
def tour(waffle, drive):
    """Drive a tour; return the robot, the maneuver and when it reported which waypoint."""

    def run(poses, *, stop_on_failure=True, **options):
        around = Surroundings(waffle, NavigationTuning(stop_on_failure=stop_on_failure))
        maneuver = FollowWaypoints(poses, waffle, around, **options)
        robot, reports = drive(maneuver)
        reported = [
            (at, fields["current_waypoint"]) for at, _, fields in reports if fields is not None
        ]
        return robot, maneuver, reported

    return run


def order(reported):
    """The waypoints in the order in which they were driven to."""
    return [index for index, _ in groupby(index for _, index in reported)]


def test_it_drives_past_a_pose_and_stands_at_the_last(through):
    """Whatever the yaw of those between; the way left shrinks over all, time runs on."""
    right = dataclasses.replace(RIGHT, yaw=2.5)
    robot, _, reports = through(right, TOP)
    assert robot.finished == SUCCEEDED
    assert robot.distance_to(TOP) < 0.05
    assert robot.pose.yaw == pytest.approx(TOP.yaw, abs=0.03)
    left = [fields["number_of_poses_remaining"] for fields in reports]
    assert sorted(set(left), reverse=True) == [2, 1]
    assert left == sorted(left, reverse=True)
    ways = [fields["distance_remaining"] for fields in reports if fields["distance_remaining"]]
    assert ways[0] > 1.2
    assert ways[-1] < 0.1
    times = [fields["navigation_time"] for fields in reports]
    assert times == sorted(times)


def test_it_does_not_slow_down_where_it_passes(through):
    """A pose on the way changes nothing."""
    _, past, _ = through(AHEAD, FURTHER)
    _, straight, _ = through(FURTHER)
    assert past == pytest.approx(straight, abs=0.03)


def test_a_pose_on_the_way_that_cannot_be_reached_ends_it_with_the_planners_code(through):
    """And says which of the poses it was."""
    robot, _, _ = through(RIGHT, IN_WALL)
    assert (robot.finished.status, robot.finished.error_code) == ("aborted", 206)
    assert robot.finished.reason.startswith("pose 1 (of 0 to 1) was not reached: ")


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
            math.dist((passed.x, passed.y), (pose.x, pose.y)) for _, passed, _ in robot.trace
        )
        assert nearest < 0.05


@pytest.mark.parametrize(
    ("poses", "options", "expected"),
    sample(
        [
            ([RIGHT, LEFT], {"loops": 1}, [0, 1, 0, 1]),
            ([RIGHT, TOP, LEFT], {"first": 2, "loops": 1}, [2, 0, 1, 2]),
        ],
        2,
    ),
    ids=["loops", "first"],
)
def test_loops_are_rounds_after_the_first_which_may_begin_in_the_middle(
    tour, poses, options, expected
):
    """As in Nav2, where 0 is one round; later rounds begin at 0."""
    assert order(tour(poses, **options)[2]) == expected


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
    robot, maneuver, _ = tour([IN_WALL, RIGHT, IN_WALL], stop_on_failure=False)
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
