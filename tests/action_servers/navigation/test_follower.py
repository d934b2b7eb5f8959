import math

import numpy as np
import pytest

from action_servers.core.drive_limits import limits
from action_servers.core.grid import survey
from action_servers.core.maneuver import Grid
from action_servers.navigation.follower import Follower
from action_servers.navigation.path import Path, cost_model, path_through, smooth
from bt_mission.base.geometry import Pose2D, Twist2D

STRAIGHT = path_through(np.column_stack((np.linspace(0.6, 3.0, 49), np.full(49, 1.1))))


@pytest.fixture
def room():
    """A room of 3.6 x 2 m without anything in it."""
    cells = np.full((48, 80), 100, dtype=np.int8)
    cells[4:-4, 4:-4] = 0
    return survey(Grid(0.05, 0.0, 0.0, cells))


@pytest.fixture
def follow(waffle, room):
    """Make a follower of a path in the room."""

    def make(path: Path, yaw: float = 0.0) -> Follower:
        return Follower(path, yaw, limits(waffle), cost_model(waffle.turning_radius), room)

    return make


def steer(follower, pose, room, *, speed=0.2, limit=math.inf):
    """What it wants at a pose; it must want something."""
    wanted = follower.steer(pose, room, speed, limit)
    assert wanted is not None
    return wanted


def test_on_a_straight_path_it_drives_ahead_at_full_speed(follow, room):
    """In the middle of the room, 0.26 m/s."""
    assert steer(follow(STRAIGHT), Pose2D(1.0, 1.1, 0.0), room) == Twist2D(0.26, 0.0)


def test_beside_the_path_it_steers_back(follow, room):
    """Left of it to the right, and the other way round."""
    assert steer(follow(STRAIGHT), Pose2D(1.0, 1.2, 0.0), room).angular < -0.05
    assert steer(follow(STRAIGHT), Pose2D(1.0, 1.0, 0.0), room).angular > 0.05


def test_it_turns_on_the_spot_before_it_drives_off(follow, room):
    """The shorter way round, and it does not drive until it is nearly aligned."""
    follower = follow(STRAIGHT)
    assert steer(follower, Pose2D(0.6, 1.1, 2.0), room).linear == 0.0
    assert steer(follower, Pose2D(0.6, 1.1, 2.0), room).angular < -1.0
    assert steer(follower, Pose2D(0.6, 1.1, 0.2), room).linear == 0.0
    assert steer(follower, Pose2D(0.6, 1.1, 0.1), room).linear > 0.0


def test_it_slows_down_towards_the_end(follow, room):
    """So that it stands there, whatever happens to the last command."""
    follower = follow(STRAIGHT)
    places = (1.0, 1.5, 2.0, 2.5, 2.93, 2.97, 2.985)
    speeds = [steer(follower, Pose2D(x, 1.1, 0.0), room).linear for x in places]
    assert speeds == sorted(speeds, reverse=True)
    assert speeds[:4] == [0.26] * 4
    assert speeds[-1] < 0.07


def test_it_goes_no_faster_than_it_is_allowed(follow, room):
    """A limit of zero stops it where it is."""
    assert steer(follow(STRAIGHT), Pose2D(1.0, 1.1, 0.0), room, limit=0.1).linear == 0.1
    assert steer(follow(STRAIGHT), Pose2D(1.0, 1.1, 0.0), room, limit=0.0) == Twist2D()


def test_it_slows_down_close_to_obstacles(follow, room):
    """Along a wall, where the robot only just fits."""
    along_wall = path_through(np.array([[0.6, 0.46], [3.0, 0.46]]))
    assert steer(follow(along_wall), Pose2D(1.0, 0.46, 0.0), room).linear < 0.2


def test_it_slows_down_in_bends(follow, room):
    """By the curvature of the arc that it drives."""
    bend = smooth(np.array([[0.6, 1.1], [1.5, 1.1], [1.5, 1.7]]), room, cost_model(0.2377))
    follower = follow(bend)
    for pose in ((0.6, 1.1, 0.0), (1.1, 1.1, 0.0), (1.4, 1.13, 0.4)):
        wanted = steer(follower, Pose2D(*pose), room)
    assert 0.05 < wanted.linear < 0.24
    assert wanted.angular > 0.3


def test_at_the_end_it_turns_to_the_goals_yaw_and_is_done(follow, room):
    """Within 0.02 rad."""
    follower = follow(STRAIGHT, yaw=1.0)
    for x in (0.6, 1.1, 1.6, 2.1, 2.6):
        steer(follower, Pose2D(x, 1.1, 0.0), room)
    assert steer(follower, Pose2D(2.995, 1.1, 0.0), room).linear == 0.0
    assert follower.remaining == 0.0
    assert follower.steer(Pose2D(2.995, 1.1, 0.99), room, 0.0, math.inf) is None


def test_a_robot_that_is_there_only_turns(follow, room):
    """0.04 m from the goal it does not drive any more."""
    follower = follow(path_through(np.array([[1.0, 1.1], [1.04, 1.1]])), yaw=-0.5)
    wanted = steer(follower, Pose2D(1.0, 1.1, 0.0), room)
    assert wanted.linear == 0.0
    assert wanted.angular < 0.0


def test_it_tells_where_the_path_has_become_too_tight(follow, room):
    """The distance to the first point without room, until that is behind."""
    follower = follow(STRAIGHT)
    marks = np.zeros(room.shape, dtype=bool)
    marks[20:24, 40:44] = True
    blocked = room.with_obstacles(marks)
    assert follower.blocked_in(room) == math.inf
    assert follower.blocked_in(blocked) == pytest.approx(2.0 - 0.2277 - 0.6, abs=0.03)
    assert follower.blocked_in(room) == math.inf


def test_a_path_that_begins_in_a_tight_place_is_not_blocked_by_it(follow, room):
    """What was tight when it was planned is no news."""
    out = path_through(np.column_stack((np.linspace(0.3, 2.0, 35), np.full(35, 1.1))))
    follower = follow(out)
    same = room.with_obstacles(np.eye(room.shape[0], room.shape[1], 60, dtype=bool))
    assert follower.blocked_in(same) > 0.5


def test_the_time_left_is_that_of_driving_and_of_the_last_turn(follow, room):
    """2.4 m at 0.26 m/s, or at the speed limit."""
    follower = follow(STRAIGHT)
    steer(follower, Pose2D(0.6, 1.1, 0.0), room)
    pose = Pose2D(0.6, 1.1, 0.0)
    assert follower.seconds_left(pose, math.inf) == pytest.approx(2.4 / 0.26)
    assert follower.seconds_left(pose, 0.1) == pytest.approx(2.4 / 0.1)
