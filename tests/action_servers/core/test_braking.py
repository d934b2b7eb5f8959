"""Facts about the speed from which a base stops in time."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from action_servers.core.braking import speed_to_stop_in


@given(st.floats(1e-6, 100.0), st.floats(0.01, 10.0), st.floats(0.0, 1.0))
def test_delay_and_braking_use_up_exactly_the_distance(distance, deceleration, delay_s):
    """Distance = v * delay + v**2 / (2 * deceleration)."""
    speed = speed_to_stop_in(distance, deceleration=deceleration, delay_s=delay_s)
    used = speed * delay_s + speed**2 / (2.0 * deceleration)
    assert used == pytest.approx(distance, rel=1e-6)


def test_no_distance_allows_no_speed():
    """Nor does one that is overrun already."""
    assert speed_to_stop_in(0.0, deceleration=1.0, delay_s=0.05) == 0.0
    assert speed_to_stop_in(-0.1, deceleration=1.0, delay_s=0.05) == 0.0


def test_a_free_way_allows_any_speed():
    """The caller has a limit of its own."""
    assert speed_to_stop_in(math.inf, deceleration=1.0, delay_s=0.05) == math.inf
