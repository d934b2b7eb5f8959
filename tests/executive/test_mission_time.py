"""Mission time never goes back, whatever is done to the clock."""

from __future__ import annotations

from bt_mission.executive.mission_time import MissionTime

S = 1_000_000_000


def lived(*readings_s: float) -> tuple[list[float], list[float]]:
    """Mission time at each tick, and the jumps that were told; s."""
    jumps: list[float] = []
    time = MissionTime(jumps.append)
    return [time.advance(round(read * S)) / S for read in readings_s], jumps


def test_it_is_ros_time_where_the_clock_only_goes_on() -> None:
    """Also where it stands still, or two ticks are far apart."""
    assert lived(1.0, 1.05, 1.05, 5.0) == ([1.0, 1.05, 1.05, 5.0], [])


def test_a_clock_that_is_set_back_takes_no_time() -> None:
    """Mission time goes on from where it was, each time."""
    assert lived(20.0, 10.0, 11.0, 3.0, 4.0) == ([20.0, 20.0, 21.0, 21.0, 22.0], [-10.0, -8.0])


def test_time_that_is_skipped_has_passed() -> None:
    """It is told; less than five seconds are not worth it."""
    assert lived(1.0, 5.9, 105.9) == ([1.0, 5.9, 105.9], [100.0])


def test_a_clock_that_starts_is_no_jump() -> None:
    """Zero is what a clock shows before the first message of ``/clock``."""
    assert lived(0.0, 0.0, 3e8, 3e8 + 1) == ([0.0, 0.0, 3e8, 3e8 + 1], [])


def test_a_simulator_that_starts_anew_at_zero() -> None:
    """Is a clock that was set back, as any."""
    assert lived(30.0, 0.0, 0.05) == ([30.0, 30.0, 30.05], [-30.0])


def test_before_the_first_tick_it_is_ros_time() -> None:
    """A node may be made on another clock than it runs on."""
    time = MissionTime(lambda jump: None)
    assert [time.at(50 * S), time.at(1 * S)] == [50 * S, 1 * S]


def test_between_two_ticks_it_does_not_go_back_either() -> None:
    """The tick that sees the clock set back is still to come."""
    time = MissionTime(lambda jump: None)
    time.advance(20 * S)
    assert time.at(10 * S) == 20 * S
    time.advance(10 * S)
    assert time.at(11 * S) == 21 * S
