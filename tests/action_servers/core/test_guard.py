import math

import numpy as np
import pytest

from action_servers.core.drive_limits import limits
from action_servers.core.guard import MARGIN_M, footprint, free_angle, free_distance, held_back
from action_servers.core.maneuver import ZERO
from bt_mission.core.geometry import Twist2D

NOTHING = np.empty((0, 2))


@pytest.fixture
def body(waffle):
    """Of a Waffle."""
    return footprint(waffle)


def test_nothing_in_sight_leaves_the_whole_horizon(body):
    """In metres ahead and behind, in radians on the spot."""
    assert free_distance(NOTHING, body, 0.0, 0.4) == 0.4
    assert free_distance(NOTHING, body, 3.0, -0.4) == 0.4
    assert free_angle(NOTHING, body, -0.5) == 0.5


def test_room_ahead_is_measured_from_the_front_of_the_hull(body):
    """A point 0.3 m from the axle is 0.231 m from the hull, less the margin, to the step below."""
    room = free_distance(np.array([[0.3, 0.0]]), body, 0.0, 0.4)
    exact = 0.3 - body.front - MARGIN_M
    assert exact - 0.02 <= room <= exact


def test_room_behind_is_measured_from_the_rear(body):
    """The Waffle reaches 0.197 m behind its axle."""
    room = free_distance(np.array([[-0.4, 0.1]]), body, 0.0, -0.4)
    exact = 0.4 + body.rear - MARGIN_M
    assert exact - 0.02 <= room <= exact


def test_what_lies_beside_the_swept_width_does_not_matter(body):
    """0.153 m half width and the margin pass at 0.165 m, and not at 0.16 m."""
    assert free_distance(np.array([[0.3, 0.165]]), body, 0.0, 0.4) == 0.4
    assert free_distance(np.array([[0.3, 0.16]]), body, 0.0, 0.4) < 0.3


def test_an_arc_turns_the_hull_towards_the_inside_of_the_bend(body):
    """A point on the left is met in a left bend and passed in a right one."""
    left = np.array([[0.25, 0.2]])
    assert free_distance(left, body, 4.0, 0.35) < 0.35
    assert free_distance(left, body, -4.0, 0.35) == 0.35


def test_a_turn_stops_before_the_rear_corner_meets_a_point(body):
    """Turning left, the rear left corner swings forward along the left side."""
    beside = np.array([[-0.14, 0.18]])
    assert free_angle(beside, body, 0.6) == 0.6
    assert free_angle(beside, body, -0.6) < 0.6


def test_a_turn_is_free_of_what_lies_outside_the_turning_circle(body):
    """The circle has no margin: paths keep just that free."""
    ring = np.arange(0.0, math.tau, 0.05)
    points = 0.239 * np.column_stack((np.cos(ring), np.sin(ring)))
    assert free_angle(points, body, math.pi) == math.pi


def test_a_point_within_the_margin_blocks_only_the_way_towards_it(body):
    """The robot can always back out of what it nearly touches."""
    touching = np.array([[body.front + 0.005, 0.0]])
    assert free_distance(touching, body, 0.0, 0.3) == 0.0
    assert free_distance(touching, body, 0.0, -0.3) == 0.3


def test_a_twist_is_slowed_before_an_obstacle_and_stopped_at_it(waffle, body):
    """The arc stays the same, so a slowed robot is where a fast one would have been."""
    bounds = limits(waffle)
    wanted = Twist2D(0.26, 0.13)
    assert held_back(wanted, NOTHING, body, bounds) == wanted
    slowed = held_back(wanted, np.array([[body.front + 0.06, 0.0]]), body, bounds)
    assert 0.0 < slowed.linear < 0.26
    assert slowed.angular / slowed.linear == pytest.approx(0.5)
    assert held_back(wanted, np.array([[body.front + 0.02, 0.0]]), body, bounds) == ZERO


def test_a_turn_is_stopped_too(waffle, body):
    """It does not swing its rear into what stands beside it."""
    bounds = limits(waffle)
    beside = np.array([[-0.14, 0.165]])
    assert held_back(Twist2D(0.0, -0.5), beside, body, bounds) == ZERO
    assert held_back(Twist2D(0.0, 0.5), beside, body, bounds) == Twist2D(0.0, 0.5)
