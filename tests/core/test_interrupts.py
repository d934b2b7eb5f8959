"""Facts about signals."""

from __future__ import annotations

import signal

import pytest

from bt_mission.core.interrupts import InterruptSignals


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_first_signal_is_noted_and_the_second_interrupts(number):
    """So that the first has time to stop the robot."""
    before = signal.getsignal(number)
    with InterruptSignals(most=1) as interrupts:
        assert interrupts.signal == ""
        signal.raise_signal(number)
        assert interrupts.signal == number.name
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
    assert signal.getsignal(number) is before


def test_without_a_limit_every_signal_is_counted():
    """Ctrl-C by the name that people know."""
    with InterruptSignals() as interrupts:
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGINT)
    assert (interrupts.count, interrupts.name, interrupts.signal) == (2, "Ctrl-C", "SIGINT")
