"""Virtual time against the wall."""

import pytest

from sim.ros.pacing import FASTEST, SpeedError, SpeedPacer, check_speed

MS = 1_000_000
S = 1_000 * MS


def pacer(speed: float = 1.0) -> SpeedPacer:
    """Wall time 100 s stands for virtual time 1 s."""
    return SpeedPacer(speed, 100 * S, 1 * S)


def test_at_speed_one_both_run_alike():
    """10 ms later on the wall, 10 ms later in the world."""
    assert pacer().target(100 * S + 10 * MS, 1 * S) == 1 * S + 10 * MS


def test_at_speed_ten_virtual_time_runs_ten_times_as_fast():
    """10 ms on the wall are 100 ms."""
    assert pacer(10.0).target(100 * S + 10 * MS, 1 * S) == 1 * S + 100 * MS


def test_time_never_goes_back():
    """Where the world is ahead already, it waits."""
    assert pacer().target(100 * S, 5 * S) == 5 * S


def test_a_short_delay_is_caught_up_with():
    """400 ms late, all of it is made good."""
    assert pacer().target(100 * S + 400 * MS, 1 * S) == 1 * S + 400 * MS


def test_a_long_delay_is_given_up():
    """After 3 s of standstill only half a second follows at once, and pacing starts anew."""
    paced = pacer()
    assert paced.target(103 * S, 1 * S) == 1 * S + 500 * MS
    assert paced.target(103 * S + 10 * MS, 1 * S + 500 * MS) == 1 * S + 510 * MS


def test_a_fast_world_does_not_leap():
    """At speed 10 half a second of the world is caught up with, not five."""
    paced = pacer(10.0)
    assert paced.target(100 * S + 40 * MS, 1 * S) == 1 * S + 400 * MS
    assert paced.target(103 * S, 1 * S + 400 * MS) == 1 * S + 900 * MS
    assert paced.target(103 * S + 10 * MS, 1 * S + 900 * MS) == 1 * S + 1000 * MS


def test_a_new_speed_holds_from_here_on():
    """What has passed stays passed."""
    paced = pacer()
    paced.set_speed(4.0, 101 * S, 2 * S)
    assert paced.target(101 * S + 10 * MS, 2 * S) == 2 * S + 40 * MS


def test_shortfall_is_told_once_a_window():
    """Of 10 s only 5.5 s could be kept: speed 0.55, told once, and not for a hiccup."""
    paced = pacer()
    paced.target(105 * S, 1 * S)
    assert paced.shortfall(105 * S) is None
    assert paced.shortfall(110 * S) == pytest.approx(0.55)
    assert paced.shortfall(110 * S + MS) is None
    paced.target(110 * S + MS, 1 * S + 500 * MS)
    hiccup = pacer()
    hiccup.target(100 * S + 900 * MS, 1 * S)
    assert hiccup.shortfall(110 * S) is None


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), 2 * FASTEST])
def test_a_useless_speed_is_refused(speed):
    """The message gives both bounds."""
    with pytest.raises(SpeedError, match=r"expected a speed from 0\.01 to 1000, got"):
        check_speed(speed)
