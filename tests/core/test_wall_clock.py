"""Virtual time against the wall."""

from collections.abc import Callable

import pytest

from bt_mission.core.wall_clock import Pacer

MS = 1_000_000
S = 1_000 * MS


class Wall:
    """A wall clock that is set."""

    now_ns = 100 * S


@pytest.fixture
def wall():
    """At 100 s."""
    return Wall()


@pytest.fixture
def due(wall):
    """Make a pacer for which 100 s on the wall are virtual time 1 s; gives it, and what is due."""

    def make(speed: float = 1.0) -> tuple[Pacer, Callable[[int, int], int]]:
        wall.now_ns = 100 * S
        pacer = Pacer(speed, 1 * S, lambda: wall.now_ns)

        def due_at(wall_ns: int, time_ns: int) -> int:
            wall.now_ns = wall_ns
            return pacer.due_ns(time_ns)

        return pacer, due_at

    return make


def test_at_speed_one_both_run_alike(due):
    """10 ms later on the wall, 10 ms later in the world."""
    _, due_at = due()
    assert due_at(100 * S + 10 * MS, 1 * S) == 1 * S + 10 * MS


def test_at_speed_ten_virtual_time_runs_ten_times_as_fast(due):
    """10 ms on the wall are 100 ms."""
    _, due_at = due(10.0)
    assert due_at(100 * S + 10 * MS, 1 * S) == 1 * S + 100 * MS


def test_time_never_goes_back(due):
    """Where the world is ahead already, it waits."""
    _, due_at = due()
    assert due_at(100 * S, 5 * S) == 5 * S


def test_a_short_delay_is_caught_up_with(due):
    """100 ms late, all of it is made good."""
    _, due_at = due()
    assert due_at(100 * S + 100 * MS, 1 * S) == 1 * S + 100 * MS


def test_a_long_delay_is_given_up(due):
    """After 3 s of standstill only a tenth of a second follows at once, and pacing starts again.

    A command holds for two tenths: what drives the robot is heard again before it brakes.
    """
    _, due_at = due()
    assert due_at(103 * S, 1 * S) == 1 * S + 100 * MS
    assert due_at(103 * S + 10 * MS, 1 * S + 100 * MS) == 1 * S + 110 * MS


def test_a_slow_world_makes_up_for_as_much_of_the_wall(due):
    """At speed 0.5, for 100 ms of the wall."""
    _, due_at = due(0.5)
    assert due_at(103 * S, 1 * S) == 1 * S + 50 * MS


def test_a_fast_world_does_not_leap(due):
    """At speed 10 half a second of the world is caught up with, not five."""
    _, due_at = due(10.0)
    assert due_at(100 * S + 40 * MS, 1 * S) == 1 * S + 400 * MS
    assert due_at(103 * S, 1 * S + 400 * MS) == 1 * S + 900 * MS
    assert due_at(103 * S + 10 * MS, 1 * S + 900 * MS) == 1 * S + 1000 * MS


def test_a_new_speed_holds_from_here_on(wall, due):
    """What has passed stays passed."""
    pacer, due_at = due()
    wall.now_ns = 101 * S
    pacer.set_speed(4.0, 2 * S)
    assert due_at(101 * S + 10 * MS, 2 * S) == 2 * S + 40 * MS


def test_shortfall_is_told_once_a_window(wall, due):
    """Of 10 s only 5.1 s could be kept: speed 0.51, reported once, and not for a short delay."""
    pacer, due_at = due()
    due_at(105 * S, 1 * S)
    assert pacer.shortfall() is None
    wall.now_ns = 110 * S
    assert pacer.shortfall() == pytest.approx(0.51)
    wall.now_ns = 110 * S + MS
    assert pacer.shortfall() is None
    due_at(110 * S + MS, 1 * S + 100 * MS)
    hiccup, due_at = due()
    due_at(100 * S + 900 * MS, 1 * S)
    wall.now_ns = 110 * S
    assert hiccup.shortfall() is None


def test_the_wall_time_to_wait_for_virtual_time(wall, due):
    """At speed 4 a second of the world is a quarter on the wall; without a speed nothing waits."""
    pacer, _ = due(4.0)
    assert pacer.ahead_s(2 * S) == pytest.approx(0.25)
    wall.now_ns = 101 * S
    assert pacer.ahead_s(2 * S) == pytest.approx(-0.75)
    assert Pacer(None, 1 * S).ahead_s(100 * S) <= 0.0
