"""Facts about signals."""

from __future__ import annotations

import signal

import pytest

from action_servers.robot_io.interrupts import SignalNote


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_first_signal_is_noted_and_the_second_interrupts(number):
    """So that the first has time to stop the robot."""
    before = signal.getsignal(number)
    with SignalNote() as interrupts:
        assert interrupts.received == ""
        signal.raise_signal(number)
        assert interrupts.received == number.name
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
    assert signal.getsignal(number) is before
