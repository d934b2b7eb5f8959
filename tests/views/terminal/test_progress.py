"""How far long work is, on a terminal and elsewhere."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import pytest

from bt_mission.base import wall_clock
from bt_mission.base.text import duration
from bt_mission.views.terminal import progress as module
from bt_mission.views.terminal.progress import LINE_S, ProgressDisplay

Clock = Callable[[float], None]


class Terminal(io.StringIO):
    """A stream that is one."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """The wall clock of progress: ``clock(3)`` moves it on by 3 s."""
    now_s = [100.0]

    class Scripted(wall_clock.Stopwatch):
        def __init__(self) -> None:
            self._begin_s = now_s[0]

        @property
        def elapsed_s(self) -> float:
            return now_s[0] - self._begin_s

    monkeypatch.setattr(module, "Stopwatch", Scripted)

    def move(seconds: float) -> None:
        now_s[0] += seconds

    return move


def test_a_line_now_and_then_where_there_is_no_terminal(clock: Clock) -> None:
    """With the first of the lines below; what was done earlier does not count for the rate."""
    stream = io.StringIO()
    remarks = (["4 workers"], ["  9 of 10 succeeded", "  1 x lost"])
    with ProgressDisplay(
        "explore", 1000, lambda: remarks, stream, done=100, unit="runs"
    ) as progress:
        progress.show(110)
        assert stream.getvalue() == ""
        clock(LINE_S)
        progress.show(120)
        progress.show(130)
    assert stream.getvalue() == (
        "explore: 120 of 1,000 runs   2/s   7 min left   4 workers 9 of 10 succeeded\n"
    )


def test_a_terminal_shows_all_lines_and_keeps_none(
    clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Names cannot command it."""
    monkeypatch.setenv("TERM", "xterm")
    stream = Terminal()
    with ProgressDisplay("a\x1b[2J", 2, lambda: ([], ["below"]), stream) as progress:
        clock(1)
        progress.show(1)
    shown = stream.getvalue()
    assert "a\\x1b[2J: 0 of 2" in shown
    assert "a\\x1b[2J: 1 of 2   1/s   1 s left" in shown
    assert "below" in shown


@pytest.mark.parametrize(
    ("options", "shown"),
    [({"plain": True}, "a: 1 of 2   0.1/s   10 s left below\n"), ({"quiet": True}, "")],
    ids=["plain", "quiet"],
)
def test_a_terminal_gets_lines_or_nothing_on_request(
    clock: Clock, options: dict[str, Any], shown: str
) -> None:
    """Nothing where a program reads."""
    stream = Terminal()
    with ProgressDisplay("a", 2, lambda: ([], ["below"]), stream, **options) as progress:
        clock(LINE_S)
        progress.show(1)
    assert stream.getvalue() == shown


@pytest.mark.parametrize(
    ("value_s", "words"),
    [
        (0.4, "0 s"),
        (99.4, "99 s"),
        (100, "2 min"),
        (5940, "99 min"),
        (7800, "2 h 10 min"),
        (300_000, "3.5 days"),
    ],
)
def test_durations_have_the_unit_that_suits_them(value_s: float, words: str) -> None:
    """To two digits or more."""
    assert duration(value_s) == words
