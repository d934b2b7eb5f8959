"""Rates from times."""

from __future__ import annotations

import pytest

from bt_mission.graph_tools.topic_messages import RateMeter

MS = 1_000_000


def test_a_rate_is_that_of_the_window() -> None:
    """Mean, least, most, deviation; all messages are counted."""
    meter = RateMeter(3)
    for at in (0, 1000, 1100, 1200, 1350):
        meter.note(at * MS)
    rate = meter.read()
    assert rate is not None
    assert rate.hz == pytest.approx(3 / 0.35)
    assert (rate.least_s, rate.most_s) == pytest.approx((0.1, 0.15))
    assert rate.deviation_s == pytest.approx(0.02357, abs=1e-5)
    assert (rate.count, meter.total) == (3, 5)


def test_one_message_has_no_rate() -> None:
    """Nor have several at one instant, as when time stands still."""
    meter = RateMeter(10)
    assert meter.read() is None
    meter.note(5 * MS)
    meter.note(5 * MS)
    assert meter.read() is None


def test_time_that_goes_back_begins_anew() -> None:
    """A simulation that was reset."""
    meter = RateMeter(10)
    for at in (900, 1000, 50, 100):
        meter.note(at * MS)
    rate = meter.read()
    assert rate is not None
    assert rate.hz == pytest.approx(20.0)
