"""How often something comes, from the times at which it came."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from itertools import pairwise


@dataclass(frozen=True)
class WindowRate:
    """The rate over a window.

    :param hz: messages per second. :param mean_s: between two messages, s; so are the others.
    """

    hz: float
    mean_s: float
    least_s: float
    most_s: float
    deviation_s: float
    count: int


class RateMeter:
    """Keeps the times of the newest messages.

    :param window: how many periods the rate is taken over.
    """

    def __init__(self, window: int) -> None:
        self._times_ns: deque[int] = deque(maxlen=window + 1)
        self.total = 0

    def note(self, time_ns: int) -> None:
        """A message came. Time that goes back, as a simulation that starts anew, begins anew."""
        if self._times_ns and time_ns < self._times_ns[-1]:
            self._times_ns.clear()
        self._times_ns.append(time_ns)
        self.total += 1

    def read(self) -> WindowRate | None:
        """The rate, or None before two messages of different times."""
        times = list(self._times_ns)
        if len(times) < 2 or times[-1] == times[0]:
            return None
        periods = [(after - before) / 1e9 for before, after in pairwise(times)]
        mean = sum(periods) / len(periods)
        spread = sum((period - mean) ** 2 for period in periods) / len(periods)
        return WindowRate(
            1.0 / mean, mean, min(periods), max(periods), math.sqrt(spread), len(periods)
        )
