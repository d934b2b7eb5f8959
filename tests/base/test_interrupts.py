"""Facts about signals."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable

import pytest

from bt_mission.base import interrupts as module
from bt_mission.base.interrupts import TWO_WISHES, InterruptSignals, TookTooLong, interrupted_after


@pytest.fixture
def apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Signals that follow each other at once count as far apart."""
    monkeypatch.setattr(module, "SAME_WISH_S", 0.0)


@pytest.mark.usefixtures("apart")
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


@pytest.mark.parametrize("most", [None, 1])
def test_a_signal_that_comes_twice_at_once_is_one_wish(
    most: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As where `ros2 launch`, `timeout` or `uv run` pass on what the terminal has sent already."""
    monkeypatch.setattr(module, "SAME_WISH_S", float("inf"))
    with InterruptSignals(most) as interrupts:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        assert interrupts.count == 1


def test_one_that_is_entered_again_notes_on_until_it_is_left_as_often():
    """A wish that comes before a mission's first step is known to that step."""
    before = signal.getsignal(signal.SIGINT)
    with InterruptSignals() as interrupts:
        signal.raise_signal(signal.SIGINT)
        with interrupts:
            assert interrupts.count == 1
        signal.raise_signal(signal.SIGTERM)
        assert interrupts.count == 2
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.usefixtures("apart")
def test_a_third_signal_interrupts_what_hangs():
    """Whether the wishes before it were signals or keys."""
    with InterruptSignals(TWO_WISHES) as interrupts:
        for _ in range(3):
            interrupts.note("the user")
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)


def limited(call: Callable[[], object]) -> None:
    """Call something again and again, for half a second: a busy machine may give less of it."""
    with interrupted_after(0.5):
        while True:
            call()


def test_code_that_computes_has_processor_time() -> None:
    """However many others compute; code that waits has as much wall time."""
    begin_s = time.process_time()
    with pytest.raises(TookTooLong):
        limited(int)
    assert time.process_time() - begin_s >= 0.5
    with pytest.raises(TookTooLong):
        limited(signal.pause)
    with interrupted_after(5.0):
        pass
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
