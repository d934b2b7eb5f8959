import math
from dataclasses import replace

import numpy as np
import pytest

from action_servers.core.footprint import footprint, free_angle, free_distance
from action_servers.core.margins import HULL_M
from bt_mission.core.robot.model import RobotModel, load_robot

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
    exact = 0.3 - body.front - HULL_M
    assert exact - 0.02 <= room <= exact


def test_room_behind_is_measured_from_the_rear(body):
    """The Waffle reaches 0.197 m behind its axle."""
    room = free_distance(np.array([[-0.4, 0.1]]), body, 0.0, -0.4)
    exact = 0.4 + body.rear - HULL_M
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


def test_what_is_beside_the_hull_does_not_stop_a_straight_drive(body):
    """Within the margin or the hull itself, as noise has it, beside the wheels and behind."""
    for x in (-0.1, 0.0, 0.05):
        assert free_distance(np.array([[x, body.half_width - 0.005]]), body, 0.0, 0.3) == 0.3


def test_what_noise_puts_into_the_hull_stops_the_way_towards_it(body):
    """A wall that the front touches, seen 0.02 m too near."""
    wall = np.array([[body.front - 0.02, side] for side in (-0.1, 0.0, 0.1)])
    assert free_distance(wall, body, 0.0, 0.3) == 0.0
    assert free_distance(wall, body, 0.0, -0.3) == 0.3


def test_a_tight_arc_is_looked_at_all_round(body):
    """5 rad within 0.03 m: the rear swings past what stands beside it."""
    assert free_distance(np.array([[-0.14, 0.18]]), body, -180.0, 0.03) < 0.03


def test_a_polygon_keeps_its_distance_by_its_edges():
    """A wedge passes points that the rectangle around it would touch, and stops at its edges."""
    waffle = load_robot("waffle").model_dump()
    outline = [[0.3, 0.0], [-0.1, 0.3], [-0.1, -0.3]]
    body = {"shape": "polygon", "outline": outline, "bottom": 0.0, "top": 0.1}
    wedge = footprint(RobotModel.model_validate(waffle | {"body": body}))
    box = replace(wedge, edges=())
    beside = np.array([[0.6, 0.15]])
    assert free_distance(beside, box, 0.0, 1.0) == pytest.approx(0.29)
    # The edge is 0.15 m aside at x = 0.1 m; the margin of 1 cm is across the edge.
    expected = 0.5 - 0.01 / 0.6
    assert free_distance(beside, wedge, 0.0, 1.0) == pytest.approx(expected, abs=0.021)
    behind = np.array([[-0.4, 0.0]])
    assert free_distance(behind, wedge, 0.0, -1.0) == pytest.approx(0.29, abs=0.021)
    assert free_distance(beside, wedge, 0.5, 1.0) > free_distance(beside, box, 0.5, 1.0)
