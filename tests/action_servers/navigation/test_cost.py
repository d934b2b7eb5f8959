import numpy as np
import pytest

from action_servers.navigation.cost import cost_model


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
