"""Facts about driving past poses to the last one."""

import pytest

from action_servers.core.maneuver import SUCCEEDED
from action_servers.navigation.surroundings import Surroundings
from action_servers.navigation.through_poses import NavigateThroughPoses
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
RIGHT, TOP = Pose2D(1.5, 0.7, 2.5), Pose2D(1.3, 1.3, -2.0)
AHEAD, FURTHER = Pose2D(1.2, 0.9, 2.5), Pose2D(1.7, 0.9, 0.0)
IN_WALL = Pose2D(0.1, 0.1, 0.0)


@pytest.fixture
def drive(waffle, world, robot_in):
    """Drive through poses; return the robot, its speeds, and what the maneuver told."""

    def run(*poses):
        robot = robot_in(world(ROOM))
        maneuver = NavigateThroughPoses(poses, waffle, Surroundings(waffle))
        reports, speeds = [], []

        def listen(robot):
            reports.append(maneuver.feedback())
            speeds.append(robot.twist.linear)

        robot.run(maneuver, 200.0, listen)
        return robot, speeds, [fields for fields in reports if fields is not None]

    return run


def test_it_drives_past_a_pose_and_stands_at_the_last(drive):
    """Whatever the yaw of those between."""
    robot, _, reports = drive(RIGHT, TOP)
    assert robot.finished == SUCCEEDED
    assert robot.distance_to(TOP) < 0.05
    assert robot.pose.yaw == pytest.approx(TOP.yaw, abs=0.03)
    left = [fields["number_of_poses_remaining"] for fields in reports]
    assert sorted(set(left), reverse=True) == [2, 1]
    assert left == sorted(left, reverse=True)


def test_it_does_not_slow_down_where_it_passes(drive):
    """A pose on the way changes nothing."""
    _, through, _ = drive(AHEAD, FURTHER)
    _, straight, _ = drive(FURTHER)
    assert through == pytest.approx(straight, abs=0.03)


def test_the_way_left_counts_all_poses_and_shrinks(drive):
    """In metres to the last pose; time runs on from one pose to the next."""
    _, _, reports = drive(RIGHT, TOP)
    ways = [fields["distance_remaining"] for fields in reports if fields["distance_remaining"]]
    assert ways[0] > 1.2
    assert ways[-1] < 0.1
    times = [fields["navigation_time"] for fields in reports]
    assert times == sorted(times)


def test_a_pose_that_cannot_be_reached_ends_it_with_the_planners_code(drive):
    """And says which of the poses it was."""
    robot, _, _ = drive(RIGHT, IN_WALL)
    assert (robot.finished.status, robot.finished.error_code) == ("aborted", 206)
    assert robot.finished.reason.startswith("pose 1 (of 0 to 1) was not reached: ")
