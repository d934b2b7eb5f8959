"""How fast virtual time runs."""

from __future__ import annotations

import pytest

from bt_mission.events.real_time_factor import RealTimeFactor

S = 1_000_000_000


def test_the_factor_is_taken_over_the_last_seconds():
    """A mission that has become faster is soon shown as such."""
    pace = RealTimeFactor()
    assert pace.factor is None
    for tenth in range(101):
        pace.note(tenth * S, tenth / 10)
    assert pace.factor == pytest.approx(10.0)
    for tenth in range(1, 101):
        pace.note(100 * S + tenth * 2 * S, 10 + tenth / 10)
    assert pace.factor == pytest.approx(20.0)


def test_time_that_begins_anew_is_no_backwards_pace():
    """The simulation was started again."""
    pace = RealTimeFactor()
    pace.note(50 * S, 0.0)
    pace.note(51 * S, 1.0)
    pace.note(1 * S, 2.0)
    assert pace.factor is None
    pace.note(2 * S, 3.0)
    assert pace.factor == pytest.approx(1.0)
