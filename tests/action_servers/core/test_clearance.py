"""Facts about the room that a scan leaves to the hull: ahead, along arcs and on the spot."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from action_servers.core import clearance
from action_servers.core.clearance import (
    HULL_M,
    footprint,
    free_angle,
    free_distance,
    into_frame,
    obstacle_points,
    of_nearest_rays,
    out_of_frame,
)
from action_servers.core.maneuver import Scan
from bt_mission.base.geometry import Pose2D
from bt_mission.robots.model import RobotModel, load_robot

WAFFLE = load_robot("waffle")
BODY = footprint(WAFFLE)
NOTHING = np.empty((0, 2))

ahead: Any = clearance.ahead
nearest_in_front: Any = clearance.nearest_in_front


def points(*places: tuple[float, float]) -> Any:
    """Points in the frame of the base, metres."""
    return np.array(places, dtype=float).T


def test_points_are_seen_from_the_base(make_scan, waffle):
    """A ray counts from the lidar, which sits behind the middle of the axle."""
    ranges = np.full(360, np.inf)
    ranges[0], ranges[90] = 1.0, 2.0
    x, y = obstacle_points(make_scan(ranges), waffle.lidar)
    assert x == pytest.approx([1.0 - 0.064, -0.064])
    assert y == pytest.approx([0.0, 2.0])


def test_a_scan_may_begin_and_turn_as_it_likes(waffle):
    """angle_min and angle_increment are obeyed, a clockwise lidar too."""
    scan = Scan(1.0, math.pi / 2, -math.pi / 2, 0.12, 3.5, np.array([1, 2, 3], dtype=np.float32))
    x, y = obstacle_points(scan, waffle.lidar)
    assert x == pytest.approx([-0.064, 2.0 - 0.064, -0.064], abs=1e-6)
    assert y == pytest.approx([1.0, 0.0, -3.0], abs=1e-6)


@pytest.mark.parametrize("junk", [math.inf, -math.inf, math.nan, 0.0, -1.0, 0.1199, 3.51, 100.0])
def test_only_measurements_are_obstacles(make_scan, waffle, junk):
    """What is no number within the limits of the lidar is left out."""
    assert obstacle_points(make_scan([junk] * 360), waffle.lidar).shape == (2, 0)


def test_the_lidars_own_minimum_holds_where_the_message_says_zero(make_scan, waffle):
    """The driver of the LDS-02 writes 0.0 to 100.0."""
    scan = make_scan([0.05, 0.13, 50.0, 101.0], range_min=0.0, range_max=100.0)
    assert obstacle_points(scan, waffle.lidar).shape == (2, 2)


@pytest.mark.parametrize("rays", [0, 1, 7, 359, 360, 361, 720])
def test_any_number_of_rays_will_do(make_scan, waffle, rays):
    """The LDS-02 sends another number every turn."""
    result = obstacle_points(make_scan([1.0] * rays), waffle.lidar)
    assert result.shape == (2, rays)


@given(arrays(np.float32, st.integers(0, 40), elements=st.floats(width=32)))
def test_no_scan_whatever_raises_or_gives_a_negative_gap(ranges):
    """Rays may hold anything a float32 can."""
    scan = Scan(1.0, 0.0, 0.157, 0.12, 3.5, ranges)
    result = obstacle_points(scan, WAFFLE.lidar)
    assert np.isfinite(result).all()
    for obstacle in (ahead(result, WAFFLE.hull), nearest_in_front(result, WAFFLE.hull)):
        assert obstacle is None or obstacle.gap >= 0.0


@pytest.mark.parametrize(
    ("places", "gap"),
    [
        ([], None),
        ([(0.569, 0.0)], 0.5),
        ([(2.0, 0.0), (1.069, 0.1), (1.5, -0.1)], 1.0),
        ([(0.06, 0.0)], 0.0),
        ([(-0.5, 0.0)], None),
        ([(1.0, 0.17)], 0.931),
        ([(1.0, -0.17)], 0.931),
        ([(1.0, 0.18)], None),
        ([(1.0, -0.18)], None),
    ],
)
def test_the_gap_is_that_of_the_nearest_point_before_the_front_of_the_hull(places, gap):
    """Within half the width, wheels included (0.153 m), and two centimetres; never negative."""
    obstacle = ahead(np.array(places, dtype=float).reshape(-1, 2).T, WAFFLE.hull)
    assert (obstacle and obstacle.gap) == (gap if gap is None else pytest.approx(gap))


@pytest.mark.parametrize(("slope", "least_deg", "most_deg"), [(0.0, -0.5, 0.5), (1.0, 5.0, 45.0)])
def test_a_wall_lies_where_it_is_nearest(slope, least_deg, most_deg):
    """A wall straight ahead lies straight ahead, whatever its noisiest ray; a slanted one left."""
    y = np.linspace(-0.16, 0.16, 33)
    x = 1.0 - slope * y
    x[-1] -= 0.01
    wall = ahead(np.stack([x, y]), WAFFLE.hull)
    assert wall.gap == pytest.approx(x.min() - 0.069)
    assert least_deg <= math.degrees(math.atan2(wall.y, wall.x)) <= most_deg


def test_the_nearest_in_front_may_stand_beside_the_way(waffle):
    """Measured from the hull's side, within 90 degrees of straight ahead."""
    nearest = nearest_in_front(points((2.0, 0.5), (0.01, -0.4), (-0.2, 0.2)), waffle.hull)
    assert (nearest.x, nearest.y) == (0.01, -0.4)
    assert nearest.gap == pytest.approx(0.4 - 0.153)


@pytest.mark.parametrize("turns", [-3, -1, 0, 1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["to the left", "to the right"])
def test_a_direction_has_the_ray_nearest_to_it_however_often_it_is_turned_round(turns, sign):
    """Halfway to the next ray, and beyond the last one of a full turn; 0 where no ray is."""
    values = np.array([1.0, 2.0, 3.0, 4.0], dtype=np.float32)
    quarters = sign * math.pi / 2 * np.array([0.0, 0.4, 0.6, 1.0, 2.0, 3.0, 3.6])
    bearings = quarters + turns * math.tau
    round_scan = Scan(0.0, 0.0, sign * math.pi / 2, 0.1, 10.0, values)
    assert of_nearest_rays(round_scan, values, bearings).tolist() == [1, 1, 2, 2, 3, 4, 1]
    half = replace(round_scan, angle_increment=sign * math.pi / 4)
    assert of_nearest_rays(half, values, bearings).tolist() == [1, 2, 2, 3, 0, 0, 0]


def test_a_point_ahead_of_a_robot_that_faces_up_lies_above_it():
    """In the robot's frame x is forward and y left."""
    facing_up = Pose2D(1.0, 2.0, math.pi / 2)
    assert out_of_frame(facing_up, np.array([[0.5, 0.0]])) == pytest.approx(np.array([[1.0, 2.5]]))
    assert into_frame(facing_up, np.array([[1.0, 2.5]])) == pytest.approx(np.array([[0.5, 0.0]]))


def room(point: tuple[float, float], curvature: float, distance: float) -> float:
    """How far a Waffle drives along an arc before it meets a point, m."""
    return free_distance(np.array([point]), BODY, curvature, distance)


def test_nothing_in_sight_leaves_the_whole_horizon():
    """In metres ahead and behind, in radians on the spot."""
    assert free_distance(NOTHING, BODY, 0.0, 0.4) == 0.4
    assert free_distance(NOTHING, BODY, 3.0, -0.4) == 0.4
    assert free_angle(NOTHING, BODY, -0.5) == 0.5


@pytest.mark.parametrize(
    ("point", "distance", "exact"),
    [
        ((0.3, 0.0), 0.4, 0.3 - BODY.front - HULL_M),
        ((-0.4, 0.1), -0.4, 0.4 + BODY.rear - HULL_M),
    ],
)
def test_room_is_measured_from_the_hull(point, distance, exact):
    """The Waffle reaches 0.069 m ahead of its axle and 0.197 m behind; to the step below."""
    assert exact - 0.02 <= room(point, 0.0, distance) <= exact


@pytest.mark.parametrize(
    ("point", "curvature", "distance", "is_free"),
    [
        pytest.param((0.3, 0.165), 0.0, 0.4, True, id="beside the swept width"),
        pytest.param((0.3, 0.16), 0.0, 0.3, False, id="within the margin of the swept width"),
        pytest.param((0.25, 0.2), 4.0, 0.35, False, id="inside the bend"),
        pytest.param((0.25, 0.2), -4.0, 0.35, True, id="outside the bend"),
        pytest.param((BODY.front + 0.005, 0.0), 0.0, -0.3, True, id="away from what it touches"),
        pytest.param((-0.1, BODY.half_width - 0.005), 0.0, 0.3, True, id="noise beside the rear"),
        pytest.param((0.0, BODY.half_width - 0.005), 0.0, 0.3, True, id="noise beside the wheels"),
        pytest.param((0.05, BODY.half_width - 0.005), 0.0, 0.3, True, id="noise beside the front"),
        pytest.param((-0.14, 0.18), -180.0, 0.03, False, id="5 rad within 0.03 m: the rear swings"),
    ],
)
def test_a_point_is_met_or_passed(point, curvature, distance, is_free):
    """By the hull and its margin, along straight lines and arcs."""
    assert (room(point, curvature, distance) == abs(distance)) is is_free


@pytest.mark.parametrize("x", [BODY.front + 0.005, BODY.front - 0.02])
def test_what_the_front_touches_stops_the_way_towards_it_alone(x):
    """Within the margin, or as noise has it, inside the hull; the robot can always back out."""
    wall = np.array([[x, side] for side in (-0.1, 0.0, 0.1)])
    assert free_distance(wall, BODY, 0.0, 0.3) == 0.0
    assert free_distance(wall, BODY, 0.0, -0.3) == 0.3


def test_a_turn_stops_before_the_rear_corner_meets_a_point():
    """Turning left, the rear left corner swings forward along the left side."""
    beside = np.array([[-0.14, 0.18]])
    assert free_angle(beside, BODY, 0.6) == 0.6
    assert free_angle(beside, BODY, -0.6) < 0.6


def test_a_turn_is_free_of_what_lies_outside_the_turning_circle():
    """The circle has no margin: paths keep just that free."""
    ring = np.arange(0.0, math.tau, 0.05)
    around = 0.239 * np.column_stack((np.cos(ring), np.sin(ring)))
    assert free_angle(around, BODY, math.pi) == math.pi


def test_a_polygon_keeps_its_distance_by_its_edges():
    """A wedge passes points that the rectangle around it would touch, and stops at its edges."""
    outline = [[0.3, 0.0], [-0.1, 0.3], [-0.1, -0.3]]
    body = {"shape": "polygon", "outline": outline, "bottom": 0.0, "top": 0.1}
    wedge = footprint(RobotModel.model_validate(WAFFLE.model_dump() | {"body": body}))
    box = replace(wedge, edges=())
    beside = np.array([[0.6, 0.15]])
    assert free_distance(beside, box, 0.0, 1.0) == pytest.approx(0.29)
    # The edge is 0.15 m aside at x = 0.1 m; the margin of 1 cm is across the edge.
    expected = 0.5 - 0.01 / 0.6
    assert free_distance(beside, wedge, 0.0, 1.0) == pytest.approx(expected, abs=0.021)
    behind = np.array([[-0.4, 0.0]])
    assert free_distance(behind, wedge, 0.0, -1.0) == pytest.approx(0.29, abs=0.021)
    assert free_distance(beside, wedge, 0.5, 1.0) > free_distance(beside, box, 0.5, 1.0)
