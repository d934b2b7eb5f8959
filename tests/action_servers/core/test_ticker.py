"""Facts about whole seconds of a goal."""

from __future__ import annotations

from action_servers.core.ticker import Ticker


def test_each_second_is_told_once():
    """Counted from the first update; a float that is a hair short counts as full."""
    ticker = Ticker()
    reports = []
    for step in range(61):
        ticker.update(10.0 + step * 0.05)
        if ticker.take():
            reports.append(step)
    assert reports == [20, 40, 60]
    assert ticker.count == 3
    assert ticker.has_reached(3.0)
    assert not ticker.has_reached(3.01)


def test_nothing_has_passed_before_the_first_update():
    """Not even no time at all."""
    ticker = Ticker()
    assert (ticker.take(), ticker.has_reached(0.0), ticker.elapsed_s) == (False, False, 0.0)


def test_a_clock_that_is_set_back_takes_nothing_back():
    """Time that has passed has passed."""
    ticker = Ticker()
    for time_s in (10.0, 12.0, 11.0):
        ticker.update(time_s)
    assert ticker.elapsed_s == 2.0
