"""How obstacles move: place and velocity as functions of time."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.world.motion import Circling, Drifting, Motion, PassingCourse, Patrolling

ROUND = Circling((1.0, 1.0), (0.0, 0.0), 80.0)
WAY = Patrolling(((0.0, 0.0), (1.0, 0.0), (1.0, 0.5)), 0.1)


PASSING = PassingCourse(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)), 0.5)
ROUND_S = (1.5 + math.sqrt(1.25)) / 0.1


@pytest.mark.parametrize(
    ("motion", "time_s", "place", "velocity"),
    [
        (ROUND, 0.0, (1, 1), None),
        (ROUND, 20.0, (-1, 1), None),
        (ROUND, 80.0, (1, 1), None),
        (Circling((1.0, 1.0), (0.0, 0.0), -80.0), 20.0, (1, -1), None),
        (WAY, 5.0, (0.5, 0), (0.1, 0)),
        (WAY, 12.0, (1, 0.2), (0, 0.1)),
        (WAY, ROUND_S + 5.0, (0.5, 0), (0.1, 0)),
        (PASSING, 1.0, (0.5, 0), (0.5, 0)),
        (PASSING, 3.0, (1, 0.5), (0, 0.5)),
        (PASSING, 4.0, (1, 1), (0, 0)),
        (PASSING, 1e6, (1, 1), (0, 0)),
        (Drifting((1.0, 2.0), (0.5, -1.0)), 10.0, (6, -8), (0.5, -1)),
        (Drifting((1.0, 2.0)), 1e6, (1, 2), (0, 0)),
    ],
)
def test_it_is_at_a_place_at_a_time(motion, time_s, place, velocity):
    """Round in a period (clockwise below 0), there and straight back, to an end, or straight on."""
    x, y, *moves = motion.at(time_s)
    assert (x, y) == pytest.approx(place)
    assert velocity is None or moves == pytest.approx(velocity)


@given(st.floats(0, 1e5), st.sampled_from([ROUND, WAY]))
def test_velocity_is_the_change_of_place(time_s, motion: Motion):
    """Over a thousandth of a second, but at corners, where half of it is still the old one."""
    x, y, vx, vy = motion.at(time_s)
    x2, y2, vx2, vy2 = motion.at(time_s + 1e-3)
    if math.hypot(vx2 - vx, vy2 - vy) < 1e-3:
        assert (x2 - x, y2 - y) == pytest.approx((vx * 1e-3, vy * 1e-3), abs=1e-6)


def test_they_stay_where_they_say():
    """The reach of a circle is its extremes, that of a way its corners."""
    assert max(x for x, _ in ROUND.reach) == pytest.approx(math.sqrt(2))
    assert WAY.reach == ((0.0, 0.0), (1.0, 0.0), (1.0, 0.5))
