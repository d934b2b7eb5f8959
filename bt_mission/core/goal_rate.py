"""How many goals a server accepts in a row: with each, every status message becomes longer."""

from __future__ import annotations

from collections import deque

MOST_GOALS = 250
"""Accepted goals whose results are kept at a time: each status message lists all of them. A client
that replaces its goal 20 times a second has 200."""

MOST_WAITING = 16_384
"""Requests that may wait, so that those beyond the limit are answered, too; of ROS's own default,
10, the middleware drops what is more without a word, and a client waits for ever."""

NS = 1_000_000_000


class GoalRate:
    """Counts the goals of an action that were accepted within the time that results are kept.

    Args:
        window_s: That time, s.
        most: Goals in it.
    """

    def __init__(self, window_s: float, most: int = MOST_GOALS) -> None:
        self._window_s = window_s
        self._most = most
        self._accepted: deque[int] = deque(maxlen=most)

    def refusal(self, now_ns: int) -> str | None:
        """Return why no goal is accepted at a ROS time, or None."""
        accepted = self._accepted
        while accepted and not 0 <= now_ns - accepted[0] < self._window_s * NS:
            accepted.popleft()  # also what was accepted before the clock was set back
        if len(accepted) == self._most:
            what = f"{self._most} goals were accepted within {self._window_s:g} s"
            return f"{what}, which is the limit: does a client send them in a loop?"
        return None

    def accept(self, now_ns: int) -> None:
        """Count a goal that is accepted at a ROS time."""
        self._accepted.append(now_ns)
