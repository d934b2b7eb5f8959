"""Facts about the room that a scan leaves to the hull."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from action_servers.core import clearance
from action_servers.core.clearance import into_frame, obstacle_points, out_of_frame
from action_servers.core.maneuver import Scan
from bt_mission.core.geometry import Pose2D
from bt_mission.core.robot.model import load_robot

WAFFLE = load_robot("waffle")

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


def test_gap_is_measured_from_the_front_of_the_hull(waffle):
    """Not from the lidar, nor from the axle."""
    assert ahead(points((0.569, 0.0)), waffle.hull).gap == pytest.approx(0.5)


def test_the_nearest_point_counts(waffle):
    """However the points are ordered."""
    assert ahead(points((2.0, 0.0), (1.069, 0.1), (1.5, -0.1)), waffle.hull).gap == pytest.approx(
        1.0
    )


@pytest.mark.parametrize(
    ("y", "seen"), [(0.17, True), (-0.17, True), (0.18, False), (-0.18, False)]
)
def test_only_the_swept_width_is_ahead(waffle, y, seen):
    """Half the width, wheels included (0.153 m), and two centimetres."""
    assert (ahead(points((1.0, y)), waffle.hull) is not None) == seen


def test_what_is_behind_is_not_ahead(waffle):
    """Nothing behind the axle stops a drive forward."""
    assert ahead(points((-0.5, 0.0)), waffle.hull) is None


def test_a_touching_obstacle_has_no_gap(waffle):
    """Noise may put it inside the hull; the gap is 0 then, not negative."""
    assert ahead(points((0.06, 0.0)), waffle.hull).gap == 0.0


def test_a_wall_straight_ahead_lies_straight_ahead(waffle):
    """Its noisiest ray, far to the left, does not decide where it is."""
    y = np.linspace(-0.16, 0.16, 33)
    x = np.full(33, 1.0)
    x[-1] -= 0.01
    wall = ahead(np.stack([x, y]), waffle.hull)
    assert wall.gap == pytest.approx(1.0 - 0.01 - 0.069)
    assert math.degrees(math.atan2(wall.y, wall.x)) == pytest.approx(0.0, abs=0.5)


def test_a_slanted_wall_lies_where_it_is_nearest(waffle):
    """To the left when its left end is nearer."""
    y = np.linspace(-0.16, 0.16, 33)
    wall = ahead(np.stack([1.0 - y, y]), waffle.hull)
    assert math.degrees(math.atan2(wall.y, wall.x)) > 5.0


def test_the_nearest_in_front_may_stand_beside_the_way(waffle):
    """Measured from the hull's side, within 90 degrees of straight ahead."""
    nearest = nearest_in_front(points((2.0, 0.5), (0.01, -0.4), (-0.2, 0.2)), waffle.hull)
    assert (nearest.x, nearest.y) == (0.01, -0.4)
    assert nearest.gap == pytest.approx(0.4 - 0.153)


def test_nothing_seen_is_none(waffle):
    """An empty world has neither."""
    nothing = np.empty((2, 0))
    assert ahead(nothing, waffle.hull) is None
    assert nearest_in_front(nothing, waffle.hull) is None


def test_a_point_ahead_of_a_robot_that_faces_up_lies_above_it():
    """In the robot's frame x is forward and y left."""
    facing_up = Pose2D(1.0, 2.0, math.pi / 2)
    assert out_of_frame(facing_up, np.array([[0.5, 0.0]])) == pytest.approx(np.array([[1.0, 2.5]]))
    assert into_frame(facing_up, np.array([[1.0, 2.5]])) == pytest.approx(np.array([[0.5, 0.0]]))
