"""How fast a mission's clock runs, against the wall's."""

from __future__ import annotations

from collections import deque

WINDOW_S = 3.0
"""Wall time over which the pace is taken."""


class RealTimeFactor:
    """Virtual seconds per second, over the last few seconds."""

    def __init__(self) -> None:
        self._seen: deque[tuple[int, float]] = deque()

    def note(self, time_ns: int, wall_s: float) -> None:
        """Take in a ROS time, ns, and the wall time at which it was heard, s."""
        if self._seen and time_ns < self._seen[-1][0]:
            self._seen.clear()  # time has begun anew
        self._seen.append((time_ns, wall_s))
        while self._seen[-1][1] - self._seen[0][1] > WINDOW_S and len(self._seen) > 2:
            self._seen.popleft()

    @property
    def factor(self) -> float | None:
        """Virtual seconds per second; None where too little was heard."""
        if len(self._seen) < 2:
            return None
        (first_ns, first_s), (last_ns, last_s) = self._seen[0], self._seen[-1]
        wall_s = last_s - first_s
        return (last_ns - first_ns) / 1e9 / wall_s if wall_s > 0.2 else None
