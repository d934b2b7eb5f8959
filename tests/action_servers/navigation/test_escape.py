import math

import numpy as np
import pytest

from action_servers.core.clearance import footprint
from action_servers.core.drive_limits import limits
from action_servers.navigation.follower import Escape, WayOut, way_out
from action_servers.navigation.surroundings import Surroundings
from bt_mission.base.geometry import Pose2D

ROOM = """
    ###########
    #.........#
    #.........#
    #.........#
    #.........#
    #.........#
    #.........#
    #.........#
    #.........#
    ###########
"""
CORRIDOR = """
    #########
    #########
    ##.....##
    ##.....##
    #########
    #########
"""


@pytest.fixture
def find(waffle, world, robot_in):
    """Look for the way out from a pose in a world."""

    def make(text: str, pose: Pose2D) -> WayOut | None:
        robot = robot_in(world(text), pose)
        around = Surroundings(waffle)
        around.observe(robot.observe())
        radius = around.cost.radius
        return way_out(pose, around.near(pose), footprint(waffle), around.survey, radius)

    return make


def test_a_robot_that_faces_a_wall_backs_out(find):
    """Where it cannot turn round, it drives backwards until it can."""
    way = find(ROOM, Pose2D(1.9, 1.0, 0.0))
    assert way is not None
    assert way.yaw == 0.0
    assert -0.2 < way.distance < -0.14


def test_a_robot_with_its_back_to_a_wall_drives_on(find):
    """Straight ahead is as good as any."""
    way = find(ROOM, Pose2D(0.42, 1.0, 0.0))
    assert way is not None
    assert way.yaw == 0.0
    assert 0.0 < way.distance < 0.1


def test_a_robot_beside_a_wall_turns_a_little_first(find):
    """Straight on it would stay as close to the wall as it is."""
    way = find(ROOM, Pose2D(1.0, 0.375, 0.0))
    assert way is not None
    assert 0.0 < abs(way.yaw) <= math.radians(60)


def test_where_there_is_no_room_there_is_no_way_out(find):
    """A corridor of 0.4 m has no place to turn in."""
    assert find(CORRIDOR, Pose2D(0.9, 0.6, 0.0)) is None


def test_a_way_out_is_driven_as_it_was_found(waffle):
    """Turn, then drive, then done; backwards is a negative velocity."""
    start = Pose2D(1.0, 1.0, 0.0)
    escape = Escape(WayOut(start, 0.5, -0.2), limits(waffle))
    turning = escape.steer(start)
    assert turning is not None
    assert (turning.linear, turning.angular > 0.5) == (0.0, True)
    backing = escape.steer(Pose2D(1.0, 1.0, 0.48))
    assert backing is not None
    assert backing.linear == -0.12
    back = -0.2 * np.array([math.cos(0.5), math.sin(0.5)])
    assert escape.remaining(Pose2D(1.0 + back[0] / 2, 1.0 + back[1] / 2, 0.5)) == pytest.approx(0.1)
    assert escape.steer(Pose2D(1.0 + back[0], 1.0 + back[1], 0.5)) is None
