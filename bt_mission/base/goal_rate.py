"""The rate at which a server accepts goals: each goal makes every status message longer."""

from __future__ import annotations

from collections import deque

MOST_GOALS = 250
"""Accepted goals whose results are kept at a time: each status message lists all of them. A client
that replaces its goal 20 times a second has 200."""

MOST_WAITING = 16_384
"""Requests to an action or a service that may wait, so that those beyond a limit are answered, too.
With ROS's default, 10, the middleware silently drops the rest, and a client waits forever.
"""

MOST_LINES = 20
"""Log lines in a second about refused requests; further ones are not logged."""

NS = 1_000_000_000


class RateLimit:
    """Limits the number of events within a time.

    Args:
        window_s: The time, s.
        most: The number of events.
    """

    def __init__(self, window_s: float, most: int) -> None:
        self._window_s = window_s
        self._most = most
        self._counted: deque[int] = deque(maxlen=most)

    def is_reached(self, now_ns: int) -> bool:
        """Return whether another event is too many at a ROS time."""
        counted = self._counted
        while counted and not 0 <= now_ns - counted[0] < self._window_s * NS:
            counted.popleft()  # also what happened before the clock was set back
        return len(counted) == self._most

    def count(self, now_ns: int) -> None:
        """Count an event at a ROS time."""
        self._counted.append(now_ns)

    def admits(self, now_ns: int) -> bool:
        """Count an event at a ROS time and return True, unless it is one too many."""
        if self.is_reached(now_ns):
            return False
        self.count(now_ns)
        return True


class GoalRate(RateLimit):
    """Counts the goals of an action that were accepted within the time that results are kept.

    Args:
        window_s: That time, s.
        most: Goals in it.
    """

    def __init__(self, window_s: float, most: int = MOST_GOALS) -> None:
        super().__init__(window_s, most)

    def refusal(self, now_ns: int) -> str | None:
        """Return why no goal is accepted at a ROS time, or None."""
        if not self.is_reached(now_ns):
            return None
        what = f"{self._most} goals were accepted within {self._window_s:g} s"
        return f"{what}, which is the limit; is a client sending goals in a loop?"
