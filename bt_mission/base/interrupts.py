"""SIGINT, SIGTERM and SIGHUP, checked between two steps; a limit for code that may block."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from types import FrameType
from typing import Any, Self

from bt_mission.base.wall_clock import Stopwatch

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that end a command. SIGHUP is sent when a terminal or a connection is closed."""

SAME_WISH_S = 0.5
"""A signal that is repeated within this wall time is the same request, s: one Ctrl-C reaches a
program twice if its parent (`ros2 launch` without a terminal, `timeout`, `uv run`) passes it on.
"""


TWO_WISHES = 2
"""For a mission: the first signal ends it in an orderly way, the second at once. Both are checked
between two steps; a third one raises KeyboardInterrupt in the middle of a step. While a user's code
does not return, `base.clock_watch` acts on them.
"""


WAITING = 0.02
"""The share of a processor below which code waits; one that computes gets more, also when busy."""


def replaced_handlers(handler: Any) -> list[tuple[signal.Signals, Any]]:
    """Handle all signals of :data:`SIGNALS`; return the former handlers.

    A SIGHUP that `nohup` has this process ignore stays ignored.
    """
    taking = partial(_take_signal, handler)
    return [
        (number, signal.signal(number, taking))
        for number in SIGNALS
        if number != signal.SIGHUP or signal.getsignal(number) is not signal.SIG_IGN
    ]


def _take_signal(handler: Any, number: int, frame: FrameType | None) -> None:
    handler(number, frame)


def takes_signal(frame: FrameType | None) -> bool:
    """Return whether a stack is within a handler of signals, which loses one if it is cut off."""
    while frame is not None and frame.f_code is not _take_signal.__code__:
        frame = frame.f_back
    return frame is not None


def name_of(number: int) -> str:
    """Return what people call a signal."""
    return "Ctrl-C" if number == signal.SIGINT else signal.Signals(number).name


class InterruptSignals:
    """Notes the signals while it is entered, which may be nested.

    Args:
        most: The number that is noted; the next one raises KeyboardInterrupt. None notes all.
    """

    def __init__(self, most: int | None = None) -> None:
        self.count = 0
        self.name = ""
        """The last one, for messages."""
        self.signal = ""
        """The last one by its name, such as SIGTERM."""
        self._listener: Callable[[], object] | None = None
        self._most = most
        self._since_last: Stopwatch | None = None
        self._former: list[list[tuple[signal.Signals, Any]]] = []

    def __enter__(self) -> Self:
        self._former.append(replaced_handlers(self._take))
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._former.pop():
            signal.signal(number, handler)

    def note(self, name: str) -> None:
        """Note a request to end, from any source."""
        self.count += 1
        self.name = name
        if self._listener is not None:
            self._listener()

    @contextmanager
    def calling(self, listener: Callable[[], object]) -> Iterator[None]:
        """Call a function at each that is noted meanwhile."""
        self._listener = listener
        try:
            yield
        finally:
            self._listener = None

    def _take(self, number: int, _: FrameType | None) -> None:
        name = signal.Signals(number).name
        if self._is_repeated(name):
            return
        self._since_last = Stopwatch()
        if self._most is not None and self.count >= self._most:
            raise KeyboardInterrupt
        self.signal = name
        self.note(name_of(number))

    def _is_repeated(self, name: str) -> bool:
        last = self._since_last
        return last is not None and name == self.signal and last.elapsed_s < SAME_WISH_S


class TookTooLong(BaseException):
    """Code has used up its time."""


@contextmanager
def interrupted_after(seconds: float) -> Iterator[None]:
    """Limit the time of a block of Python code, s: processor time, or wall time in which it waits.

    On a busy machine, code that computes gets its time. Only the main thread gets signals, so
    elsewhere there is no limit; nor is there one for code that blocks outside of Python.

    Raises:
        TookTooLong: In the block, once the time is over.
    """
    begin_s = before_s = time.process_time()

    def look(*_: object) -> None:
        nonlocal before_s
        now_s = time.process_time()
        passed_s, before_s = now_s - before_s, now_s
        if passed_s < WAITING * seconds or now_s - begin_s >= seconds:
            raise TookTooLong

    try:
        former = signal.signal(signal.SIGALRM, look)
    except ValueError:  # not the main thread
        yield
        return
    left, interval = signal.setitimer(signal.ITIMER_REAL, seconds, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, left, interval)
        signal.signal(signal.SIGALRM, former)
