"""What is due when, in which order."""

import pytest

from sim.ros.schedule import RateError, Schedule, period_of

START = 1_000_000_000


def test_everything_is_due_at_the_start_and_then_at_its_rate():
    """20 Hz and 10 Hz meet every 100 ms, in the order in which they were added."""
    schedule, runs = Schedule(START), []
    schedule.every(20.0, "fast", lambda index: runs.append(("fast", index)))
    schedule.every(10.0, "slow", lambda index: runs.append(("slow", index)))
    instants = []
    while schedule.next_due_ns <= START + 100_000_000:
        instants.append(schedule.next_due_ns - START)
        schedule.run(schedule.next_due_ns)
    assert instants == [0, 50_000_000, 100_000_000]
    assert runs == [("fast", 0), ("slow", 0), ("fast", 1), ("fast", 2), ("slow", 1)]


def test_once_is_once():
    """It runs at the start, in its place, and does not hold up the rest."""
    schedule, runs = Schedule(START), []
    schedule.once(lambda index: runs.append("once"))
    schedule.every(10.0, "slow", lambda index: runs.append("slow"))
    for _ in range(3):
        schedule.run(schedule.next_due_ns)
    assert runs == ["once", "slow", "slow", "slow"]
    assert schedule.next_due_ns == START + 300_000_000


@pytest.mark.parametrize(
    ("rate", "period_ms"), [(5, 200), (10, 100), (20, 50), (40, 25), (100, 10), (200, 5)]
)
def test_periods_are_whole_steps(rate, period_ms):
    """The usual rates fit 5 ms."""
    assert period_of(rate, "lidar.rate") == period_ms * 1_000_000


@pytest.mark.parametrize("rate", [30.0, 400.0, 7.0])
def test_a_rate_that_does_not_fit_is_refused_with_both_numbers(rate):
    """The message names what was to run, its rate and the step."""
    with pytest.raises(RateError, match=rf"camera\.rate: .* of 5 ms, got {rate:g} Hz"):
        period_of(rate, "camera.rate")
