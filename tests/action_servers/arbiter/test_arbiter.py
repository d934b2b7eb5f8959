"""Facts about who may drive."""

from __future__ import annotations

import math

import pytest

from action_servers.arbiter.arbiter import SOURCES, Arbiter, CommandAge
from action_servers.core.maneuver import ZERO
from bt_mission.core.geometry import Twist2D

STOP, JOY, MISSION = (source.topic for source in SOURCES)
SLOW, FAST = Twist2D(0.1, 0.0), Twist2D(0.2, 0.5)
MS = 1_000_000


@pytest.fixture
def arbiter() -> Arbiter:
    """The arbiter with its usual sources."""
    return Arbiter()


def test_stop_stands_over_the_joystick_and_the_joystick_over_missions():
    """In this order, from the highest rank."""
    assert (STOP, JOY, MISSION) == ("cmd_vel_stop", "cmd_vel_joy", "cmd_vel_mission")


def test_a_source_that_is_alone_drives_at_once(arbiter):
    """Its command is passed on as it is."""
    assert arbiter.take(MISSION, FAST, 0) == FAST
    assert arbiter.leader(0) == MISSION
    assert arbiter.step(20 * MS) is None


def test_a_lower_source_is_not_heard_while_a_higher_one_speaks(arbiter):
    """And a higher one takes over with its first command."""
    arbiter.take(MISSION, FAST, 0)
    assert arbiter.take(JOY, SLOW, 10 * MS) == SLOW
    assert arbiter.take(MISSION, FAST, 50 * MS) is None
    assert arbiter.leader(50 * MS) == JOY


def test_the_joystick_gives_way_exactly_half_a_second_after_its_last_word(arbiter):
    """Not a nanosecond earlier."""
    arbiter.take(JOY, SLOW, 0)
    assert arbiter.take(MISSION, FAST, 500 * MS - 1) is None
    assert arbiter.take(MISSION, FAST, 500 * MS) == FAST


def test_a_base_is_told_to_stand_when_everybody_is_silent(arbiter):
    """A mission counts for 0.15 s, and then zero is commanded until somebody speaks."""
    assert arbiter.step(0) == ZERO
    arbiter.take(MISSION, FAST, 0)
    assert arbiter.step(150 * MS - 1) is None
    assert arbiter.step(150 * MS) == ZERO
    assert arbiter.step(170 * MS) == ZERO


def test_whatever_stop_says_means_zero(arbiter):
    """A stop that names a speed by mistake still stops."""
    arbiter.take(JOY, FAST, 0)
    assert arbiter.take(STOP, FAST, 1) == ZERO
    assert arbiter.take(JOY, FAST, 2) is None
    assert arbiter.take(MISSION, FAST, 3) is None


@pytest.mark.parametrize("twist", [Twist2D(math.nan, 0.0), Twist2D(0.0, math.inf)])
def test_a_command_that_is_no_number_counts_as_silence(arbiter, twist):
    """The source falls silent with it, and a base that it drove is told to stand."""
    arbiter.take(MISSION, FAST, 0)
    with pytest.raises(ValueError, match="cmd_vel_mission commanded"):
        arbiter.take(MISSION, twist, 100 * MS)
    assert arbiter.step(150 * MS) == ZERO


def test_a_clock_that_is_set_back_ends_what_was_heard_before(arbiter):
    """As when a simulation begins anew."""
    arbiter.take(JOY, SLOW, 10_000 * MS)
    assert arbiter.step(0) == ZERO
    assert arbiter.take(MISSION, FAST, 0) == FAST


def test_a_command_counts_from_when_it_was_sent(arbiter):
    """One that was under way for a while is given as much less time; too late, it counts not."""
    assert arbiter.take(MISSION, FAST, 1000 * MS, age_ns=100 * MS) == FAST
    assert arbiter.step(1050 * MS - 1) is None
    assert arbiter.step(1050 * MS) == ZERO
    assert arbiter.take(MISSION, FAST, 1100 * MS, age_ns=150 * MS) is None
    assert arbiter.step(1100 * MS) == ZERO


def test_a_stop_counts_however_late_it_comes(arbiter):
    """From when it is heard."""
    assert arbiter.take(STOP, ZERO, 1000 * MS, age_ns=5000 * MS) == ZERO
    assert arbiter.take(JOY, SLOW, 1500 * MS - 1) is None


@pytest.mark.parametrize("ahead_ms", [0, -3_600_000, 400])
def test_an_age_does_not_depend_on_how_clocks_are_set(ahead_ms):
    """Only on how much longer a command took than the fastest before it."""
    age = CommandAge()
    sent = [(10_000, 10_010), (10_050, 10_055), (10_100, 10_290), (10_150, 10_295)]
    results = [age.of((at + ahead_ms) * MS, here * MS) // MS for at, here in sent]
    assert results == [0, 0, 185, 140]


def test_a_source_whose_clock_is_set_back_is_heard_again():
    """After the 2 s in which what came before is compared with."""
    age = CommandAge()
    assert age.of(100_000 * MS, 100_000 * MS) == 0
    ages = [age.of(at * MS, (100_000 + at) * MS) // MS for at in range(50, 2200, 50)]
    assert ages == [100_000] * 39 + [0] * 4


def test_after_a_long_silence_a_command_is_compared_with_the_last():
    """What has waited all that time is as old as it is."""
    age = CommandAge()
    assert age.of(1000 * MS, 1000 * MS) == 0
    assert age.of(1050 * MS, 61_000 * MS) == 59_950 * MS


def test_a_command_without_a_stamp_counts_as_new():
    """ROS takes zero for no stamp."""
    assert CommandAge().of(0, 5 * MS) == 0
