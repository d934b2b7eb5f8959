"""Encoders: the turning of the wheels, and what they spin in vain."""

import pytest

from sim.sensors.odometry import Encoders


def read(encoders: Encoders, times: int) -> tuple[float, ...]:
    """Angles after both wheels have turned by 0.1 rad that many times."""
    for index in range(1, times + 1):
        encoders.read(0.1 * index, 0.1 * index)
    return encoders.angles(0.1 * times, 0.1 * times)


def test_without_slip_they_show_what_is():
    """From the angles at the start on."""
    encoders = Encoders(0.0, seed=1)
    encoders.start(2.0, -3.0)
    assert encoders.angles(2.5, -3.0) == (0.5, 0.0)


def test_slip_is_the_mean_share_that_is_shown_too_much():
    """5 % over a thousand readings, other for each wheel."""
    left, right = read(Encoders(0.05, seed=1), 1000)
    assert left == pytest.approx(105, abs=0.5)
    assert right == pytest.approx(105, abs=0.5)
    assert left != right


def test_started_again_they_slip_the_same():
    """The stream of random numbers begins anew."""
    encoders = Encoders(0.05, seed=1)
    first = read(encoders, 20)
    encoders.start(0.0, 0.0)
    assert read(encoders, 20) == first
    assert read(Encoders(0.05, seed=2), 20) != first


def test_they_tell_how_far_both_have_turned():
    """Whatever the direction."""
    encoders = Encoders(0.0, seed=1)
    encoders.read(1.0, -2.0)
    assert encoders.read(0.5, -3.0) == pytest.approx(1.5)
