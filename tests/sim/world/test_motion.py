"""How obstacles move: place and velocity as functions of time."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.world.motion import Circling, Drifting, Motion, PassingCourse, Patrolling

ROUND = Circling((1.0, 1.0), (0.0, 0.0), 80.0)
WAY = Patrolling(((0.0, 0.0), (1.0, 0.0), (1.0, 0.5)), 0.1)


def test_circling_comes_round_in_its_period():
    """A quarter of 80 s is a quarter of the circle; after 80 s it is home."""
    assert ROUND.at(0.0)[:2] == pytest.approx((1, 1))
    assert ROUND.at(20.0)[:2] == pytest.approx((-1, 1))
    assert ROUND.at(80.0)[:2] == pytest.approx((1, 1))


def test_a_period_below_zero_is_clockwise():
    """The other way round."""
    assert Circling((1.0, 1.0), (0.0, 0.0), -80.0).at(20.0)[:2] == pytest.approx((1, -1))


def test_patrolling_goes_through_its_points_and_straight_back():
    """1 m, 0.5 m and 1.118 m at 0.1 m/s."""
    assert WAY.at(5.0) == pytest.approx((0.5, 0, 0.1, 0))
    assert WAY.at(12.0) == pytest.approx((1, 0.2, 0, 0.1))
    round_s = (1.5 + math.sqrt(1.25)) / 0.1
    assert WAY.at(round_s + 5.0) == pytest.approx((0.5, 0, 0.1, 0))


@given(st.floats(0, 1e5), st.sampled_from([ROUND, WAY]))
def test_velocity_is_the_change_of_place(time_s, motion: Motion):
    """Over a thousandth of a second, but at corners, where half of it is still the old one."""
    x, y, vx, vy = motion.at(time_s)
    x2, y2, vx2, vy2 = motion.at(time_s + 1e-3)
    if math.hypot(vx2 - vx, vy2 - vy) < 1e-3:
        assert (x2 - x, y2 - y) == pytest.approx((vx * 1e-3, vy * 1e-3), abs=1e-6)


def test_they_stay_where_they_say():
    """The reach of a circle is its extremes, that of a way its corners."""
    radius = math.sqrt(2)
    assert max(x for x, _ in ROUND.reach) == pytest.approx(radius)
    assert WAY.reach == ((0.0, 0.0), (1.0, 0.0), (1.0, 0.5))


def test_a_way_with_an_end_is_stood_at():
    """1 m and 1 m round a corner at 0.5 m/s; from 4 s on it stands at the last point."""
    way = PassingCourse(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)), 0.5)
    assert way.at(1.0) == pytest.approx((0.5, 0, 0.5, 0))
    assert way.at(3.0) == pytest.approx((1, 0.5, 0, 0.5))
    assert way.at(4.0) == way.at(1e6) == (1.0, 1.0, 0.0, 0.0)


def test_drifting_is_straight_on_or_standing():
    """For ever."""
    assert Drifting((1.0, 2.0), (0.5, -1.0)).at(10.0) == (6.0, -8.0, 0.5, -1.0)
    assert Drifting((1.0, 2.0)).at(1e6) == (1.0, 2.0, 0.0, 0.0)
