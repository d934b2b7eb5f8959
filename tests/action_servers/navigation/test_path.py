import math

import numpy as np
import pytest

from action_servers.core.grid import survey
from action_servers.navigation.path import cost_model, path_through, smooth, straighten

COST = cost_model(0.238)
BEND = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])


@pytest.fixture
def pillar(world):
    """A room of 4 x 2.8 m with a pillar of 0.2 m in the middle."""
    return survey(
        world(
            """
            ####################
            #..................#
            #..................#
            #..................#
            #..................#
            #..................#
            #........#.........#
            #..................#
            #..................#
            #..................#
            #..................#
            #..................#
            #..................#
            ####################
            """
        ).grid
    )


def test_a_path_knows_its_length_and_its_points():
    """Length runs along the polyline, and before the start and behind the end are the ends."""
    path = path_through(BEND)
    assert path.length == 2.0
    assert path.at(1.5) == (1.0, 0.5)
    assert path.at(-1.0) == (0.0, 0.0)
    assert path.at(9.0) == (1.0, 1.0)
    assert path.end_direction() == pytest.approx(math.pi / 2)


def test_the_nearest_place_is_a_foot_on_a_segment():
    """It says how far along it is, and how far away."""
    assert path_through(BEND).nearest(0.4, 0.3, 0.0, 2.0) == pytest.approx((0.4, 0.3))


def test_the_nearest_place_is_looked_for_within_a_stretch():
    """A path that comes back to where it has been is not cut short."""
    there_and_back = path_through(np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 0.1], [0.0, 0.1]]))
    along, _ = there_and_back.nearest(0.5, 0.1, 0.4, 1.0)
    assert along == pytest.approx(0.5)


def test_steps_over_cells_become_one_line(pillar):
    """Where nothing is in the way, a staircase is a straight line in the end."""
    stairs = np.array([[0.5 + 0.05 * ((k + 1) // 2), 0.5 + 0.05 * (k // 2)] for k in range(21)])
    assert straighten(stairs, pillar, COST).tolist() == [stairs[0].tolist(), stairs[-1].tolist()]


def test_a_line_does_not_pass_closer_to_a_pillar_than_the_path_it_replaces(pillar):
    """Straightening weighs clearance as the search did."""
    around = np.array([[1.0, 1.3], [1.9, 2.0], [2.8, 1.3]])
    straight = straighten(around, pillar, COST)
    assert len(straight) == 3


def test_smoothing_keeps_both_ends_and_rounds_the_corner(pillar):
    """No turn between neighbouring points is sharp any more."""
    path = smooth(0.6 + BEND, pillar, COST)
    assert path.points[0].tolist() == [0.6, 0.6]
    assert path.points[-1].tolist() == [1.6, 1.6]
    steps = np.diff(path.points, axis=0)
    turns = np.abs(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))))
    assert turns.max() < math.radians(20)
    assert turns.sum() == pytest.approx(math.pi / 2, abs=0.05)


def test_smoothing_leaves_a_corner_sharp_that_has_no_room(pillar):
    """Clearance comes before smoothness."""
    hugging = np.array([[1.6, 1.0], [1.6, 1.8], [2.2, 1.8], [2.2, 1.0]])
    path = smooth(hugging, pillar, COST)
    assert pillar.clearance_at(path.points).min() == pytest.approx(0.2)
    steps = np.diff(path.points, axis=0)
    turns = np.abs(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))))
    assert turns.max() > math.radians(20)


def test_a_path_to_where_the_robot_stands_has_no_length(pillar):
    """Start and goal may coincide."""
    here = np.array([[0.6, 0.6], [0.6, 0.6]])
    path = smooth(straighten(here, pillar, COST), pillar, COST)
    assert path.length == 0.0
    assert path.nearest(0.7, 0.6, 0.0, 1.0) == pytest.approx((0.0, 0.1))


def test_room_costs_nothing_and_a_tight_place_five_times_as_much():
    """From comfort on a metre costs 1, at the radius 5, and in between the more the tighter."""
    cost = cost_model(0.238)
    assert cost.radius == pytest.approx(0.248)
    prices = cost.price(np.array([cost.radius, 0.3, 0.4, cost.comfort, 2.0]))
    assert prices[0] == pytest.approx(5.0)
    assert prices[3:] == pytest.approx([1.0, 1.0])
    assert np.all(np.diff(prices[:4]) < 0)


def test_closer_than_allowed_costs_no_more_than_the_worst_that_is():
    """A robot that starts in a tight place can still compare ways out."""
    cost = cost_model(0.238)
    assert cost.price(np.array([0.0])) == pytest.approx([5.0])
