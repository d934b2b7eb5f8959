"""The one place that looks at the wall clock: pacing live runs, and how long a run took."""

from __future__ import annotations

import time

NS = 1_000_000_000


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

    def hold(self, time_ns: int) -> None:
        """Return when the wall has reached virtual time ``time_ns``."""
        if self._speed is None:
            return
        ahead_s = (time_ns - self._start_ns) / NS / self._speed - self._watch.elapsed_s
        if ahead_s > 0:
            time.sleep(ahead_s)
