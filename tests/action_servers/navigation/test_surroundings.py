import dataclasses
import math

import numpy as np
import pytest

from action_servers.navigation.surroundings import Surroundings
from bt_mission.core.geometry import Pose2D

ROOM = """
    ###############
    #.............#
    #.............#
    #.............#
    #.............#
    #..R.....o....#
    #.............#
    #.............#
    #.............#
    #.............#
    ###############
"""


@pytest.fixture
def robot(world, robot_in):
    """A Waffle in a room with an obstacle that the map does not have."""
    return robot_in(world(ROOM))


def test_nothing_is_known_before_map_and_scan(waffle, robot):
    """A scan without a pose cannot be placed."""
    around = Surroundings(waffle)
    now = robot.observe()
    ready = []
    for pose in (None, robot.pose):
        around.observe(dataclasses.replace(now, map_pose=pose))
        ready.append(around.ready)
    assert ready == [False, True]
    assert around.seen_s == 10.0


def test_the_survey_has_what_the_lidar_adds_and_the_map_has_not(waffle, robot):
    """The obstacle is in the one, not in the other."""
    around = Surroundings(waffle)
    around.observe(robot.observe())
    edge = (9 * 0.2 - 0.01, 5.5 * 0.2)
    assert around.mapped.clearance_of(*edge) > 0.5
    assert around.survey.clearance_of(*edge) < 0.05


def test_a_scan_is_placed_where_the_robot_was_when_it_was_taken(waffle, robot):
    """A robot that has turned by 1 rad since sees no obstacle in a new direction."""
    still, turning = Surroundings(waffle), Surroundings(waffle)
    now = robot.observe()
    still.observe(now)
    later = dataclasses.replace(
        now,
        time_s=10.1,
        odom_stamp_s=10.1,
        map_pose=dataclasses.replace(robot.pose, yaw=1.0),
    )
    turning.observe(dataclasses.replace(now, scan=None))
    turning.observe(later)
    assert np.array_equal(turning.survey.occupied, still.survey.occupied)


def test_a_scan_between_two_poses_is_placed_between_them(waffle, robot):
    """Half way in time is half way in angle."""
    around = Surroundings(waffle)
    robot.pose = dataclasses.replace(robot.pose, yaw=0.3)
    now = robot.observe()
    at = {yaw: dataclasses.replace(robot.pose, yaw=yaw) for yaw in (0.2, 0.4)}
    around.observe(dataclasses.replace(now, scan=None, odom_stamp_s=9.95, map_pose=at[0.2]))
    around.observe(dataclasses.replace(now, odom_stamp_s=10.05, map_pose=at[0.4]))
    exact = Surroundings(waffle)
    exact.observe(now)
    assert np.array_equal(around.survey.occupied, exact.survey.occupied)


def test_a_scan_from_before_the_first_pose_is_left_out(waffle, robot):
    """Where the robot was then is not known."""
    around = Surroundings(waffle)
    now = robot.observe()
    around.observe(dataclasses.replace(now, odom_stamp_s=10.2))
    assert not around.ready


def test_a_clock_that_is_set_back_starts_the_poses_anew(waffle, robot):
    """Poses of the future are worth nothing."""
    around = Surroundings(waffle)
    now = robot.observe()
    elsewhere = Pose2D(0.5, 0.5, 3.0)
    around.observe(dataclasses.replace(now, scan=None, odom_stamp_s=99.0, map_pose=elsewhere))
    around.observe(now)
    assert around.seen_s == 10.0


def test_what_is_near_is_seen_from_the_pose_asked_for(waffle, robot):
    """The obstacle's face is 1.1 m from the start, and 0.1 m nearer from 0.1 m on."""
    around = Surroundings(waffle)
    around.observe(robot.observe())
    ahead = dataclasses.replace(robot.pose, x=robot.pose.x + 0.1)
    points = around.near(ahead)
    face = points[np.abs(points[:, 1]) < 0.02].max(axis=0)
    assert face[0] == pytest.approx(1.0, abs=0.03)


def test_the_same_map_again_changes_nothing(waffle, robot):
    """A latched map may be sent again and again."""
    around = Surroundings(waffle)
    now = robot.observe()
    around.observe(now)
    before = around.survey
    same = dataclasses.replace(robot.world.grid, cells=robot.world.grid.cells.copy())
    around.observe(dataclasses.replace(now, grid=same))
    assert around.survey is before


def test_another_map_keeps_what_was_seen(waffle, robot):
    """The marks are looked up in the new map."""
    around = Surroundings(waffle)
    now = robot.observe()
    around.observe(now)
    cells = robot.world.grid.cells.copy()
    cells[20:24, 40:44] = 100
    around.observe(
        dataclasses.replace(now, grid=dataclasses.replace(robot.world.grid, cells=cells))
    )
    assert around.mapped.clearance_of(2.1, 1.1) == 0.0
    assert around.survey.clearance_of(1.79, 1.1) < 0.05


def test_roads_are_made_once_for_a_survey(waffle, robot):
    """Planning twice over the same survey searches the same roads."""
    around = Surroundings(waffle)
    around.observe(robot.observe())
    assert around.roads is around.roads
    assert around.roads.survey is around.survey


def test_forgetting_leaves_the_map(waffle, robot):
    """Until the next scan shows what is really there."""
    around = Surroundings(waffle)
    around.observe(robot.observe())
    around.forget()
    assert around.survey is around.mapped
    assert math.isclose(around.seen_s or 0.0, 10.0)
