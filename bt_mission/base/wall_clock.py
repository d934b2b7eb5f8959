"""The only module that reads the wall clock: pacing and duration of runs, dates of permits."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from bt_mission.base.stamps import NS

LONGEST_SLEEP_S = 0.1
"""The longest delay of Ctrl-C."""

MOST_LAG_NS = 100_000_000
"""Time of the wall clock, ns, that is caught up; an older lag is given up, so on a busy machine the
world runs slower. While the world catches up the driver of the robot receives nothing, and its
commands hold for 200 ms of the wall clock: less time than that passes at once.
"""

MOST_LEAP_NS = 500_000_000
"""Time of the world, ns, that is caught up with at most, at any speed: sensors that are silent for
longer count as late."""

WINDOW_NS = 10_000_000_000
"""Wall time, ns, over which the speed that is reached is measured."""


class Stopwatch:
    """Wall time since it was made, in seconds."""

    def __init__(self) -> None:
        self._start = time.perf_counter()

    @property
    def elapsed_s(self) -> float:
        """Seconds of wall time so far."""
        return time.perf_counter() - self._start


def unix_s() -> float:
    """Return the time of this machine, in seconds since 1970."""
    return time.time()


class Pacer:
    """Keeps virtual time at a speed, from one instant of wall and virtual time on.

    Args:
        speed: Virtual seconds per wall second; None runs as fast as possible.
        start_ns: The virtual time that is due now.
        wall_ns: Returns wall time in ns, counted from any instant.
    """

    def __init__(
        self, speed: float | None, start_ns: int, wall_ns: Callable[[], int] = time.perf_counter_ns
    ) -> None:
        self._wall_ns = wall_ns
        self.set_speed(speed, start_ns)

    def set_speed(self, speed: float | None, time_ns: int) -> None:
        """Continue at another speed from here."""
        self.speed = math.inf if speed is None else speed
        self._start_ns = time_ns
        self._start_wall_ns = self._window_wall_ns = self._wall_ns()
        self._lost_ns = 0

    def ahead_s(self, time_ns: int) -> float:
        """Return the wall time until virtual time `time_ns` is due, s; not above 0 if it is."""
        passed_ns = self._wall_ns() - self._start_wall_ns
        return ((time_ns - self._start_ns) / self.speed - passed_ns) / NS

    def hold(self, time_ns: int, is_wanted: Callable[[], bool]) -> None:
        """Wait until virtual time `time_ns` is due, or until an interrupt."""
        while (ahead_s := self.ahead_s(time_ns)) > 0 and not is_wanted():
            rest(ahead_s)

    def due_ns(self, time_ns: int) -> int:
        """Return the virtual time that is due, ns, for `time_ns`; never less.

        A lag of more than `MOST_LAG_NS` of the wall clock, or `MOST_LEAP_NS` of the world, is given
        up.
        """
        wall_ns = self._wall_ns()
        due_ns = self._start_ns + round((wall_ns - self._start_wall_ns) * self.speed)
        most_ns = min(round(MOST_LAG_NS * self.speed), MOST_LEAP_NS)
        lag_ns = due_ns - time_ns
        if lag_ns > most_ns:
            self._lost_ns += round((lag_ns - most_ns) / self.speed)
            due_ns = time_ns + most_ns
            self._start_wall_ns, self._start_ns = wall_ns, due_ns
        return max(due_ns, time_ns)

    def shortfall(self) -> float | None:
        """Return the speed reached, once a window, if it is less than 0.9 of the set one."""
        wall_ns = self._wall_ns()
        window_ns = wall_ns - self._window_wall_ns
        if window_ns < WINDOW_NS:
            return None
        reached = 1 - self._lost_ns / window_ns
        self._window_wall_ns, self._lost_ns = wall_ns, 0
        return self.speed * reached if reached < 0.9 else None


def rest(seconds: float) -> None:
    """Let wall time pass, at most :data:`LONGEST_SLEEP_S`."""
    if seconds > 0:
        time.sleep(min(seconds, LONGEST_SLEEP_S))
