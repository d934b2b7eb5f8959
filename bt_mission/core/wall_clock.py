"""The one place that looks at the wall clock: pacing live runs, and how long a run took."""

from __future__ import annotations

import time
from collections.abc import Callable

NS = 1_000_000_000

LONGEST_SLEEP_S = 0.1
"""How long Ctrl-C waits at most."""


class Stopwatch:
    """Wall time since it was made, in seconds."""

    def __init__(self) -> None:
        self._start = time.perf_counter()

    @property
    def elapsed_s(self) -> float:
        """Seconds of wall time so far."""
        return time.perf_counter() - self._start


class Pacer:
    """Holds virtual time back to a chosen speed.

    :param speed: virtual seconds per wall second; None runs as fast as the machine can.
    :param start_ns: the virtual time at which the wall's count starts.
    """

    def __init__(self, speed: float | None, start_ns: int) -> None:
        self._speed = speed
        self._start_ns = start_ns
        self._watch = Stopwatch()

    def ahead_s(self, time_ns: int) -> float:
        """Wall time until virtual time ``time_ns`` is due, s; not above 0 when it is."""
        if self._speed is None:
            return 0.0
        return (time_ns - self._start_ns) / NS / self._speed - self._watch.elapsed_s

    def hold(self, time_ns: int, is_wanted: Callable[[], bool]) -> None:
        """Return when the wall has reached virtual time ``time_ns``, or when somebody is wanted."""
        while (ahead_s := self.ahead_s(time_ns)) > 0 and not is_wanted():
            rest(ahead_s)


def rest(seconds: float) -> None:
    """Let wall time pass, at most :data:`LONGEST_SLEEP_S`."""
    if seconds > 0:
        time.sleep(min(seconds, LONGEST_SLEEP_S))
