"""Mission time never goes back, whatever is done to the clock."""

from __future__ import annotations

import pytest

from bt_mission.executive.mission_time import MissionTime

S = 1_000_000_000


@pytest.mark.parametrize(
    ("readings", "times", "jumps"),
    [
        ((1.0, 1.05, 1.05, 5.0), [1.0, 1.05, 1.05, 5.0], []),
        ((20.0, 10.0, 11.0, 3.0, 4.0), [20.0, 20.0, 21.0, 21.0, 22.0], [-10.0, -8.0]),
        ((1.0, 5.9, 105.9), [1.0, 5.9, 105.9], [100.0]),
        ((0.0, 0.0, 3e8, 3e8 + 1), [0.0, 0.0, 3e8, 3e8 + 1], []),
        ((30.0, 0.0, 0.05), [30.0, 30.0, 30.05], [-30.0]),
    ],
    ids=[
        "it is ROS time where the clock only goes on",
        "a clock that is set back takes no time",
        "time that is skipped has passed, and is told from five seconds on",
        "a clock that starts is no jump: zero comes before the first message of /clock",
        "a simulator that starts anew at zero",
    ],
)
def test_mission_time(readings: tuple[float, ...], times: list[float], jumps: list[float]) -> None:
    """At each tick, and the jumps that are told; s."""
    skipped: list[float] = []
    time = MissionTime(skipped.append)
    assert [time.advance(round(read * S)) / S for read in readings] == times
    assert skipped == jumps


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
