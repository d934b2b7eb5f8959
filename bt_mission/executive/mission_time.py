"""Mission time, from a clock that may be set.

ROS time is the clock of the publisher of ``/clock``, or of this machine. A simulator that is reset
sets it back, and a node that waits for an instant would then wait for all that time once more. So
mission time never goes back, and each limit keeps the time that it had left. Skipped time has
passed, as for all other nodes of the graph.
"""

from __future__ import annotations

from collections.abc import Callable

LEAP_NS = 5_000_000_000
"""A larger step between two readings is a jump. A smaller one may be a slow publisher of
``/clock``, or a fast simulation.
"""


class MissionTime:
    """Mission time, from readings of ROS time.

    Args:
        on_jump: Called with each jump of the clock, s; negative if it was set back.
    """

    def __init__(self, on_jump: Callable[[float], None]) -> None:
        self._on_jump = on_jump
        self._read_ns: int | None = None
        self._behind_ns = 0

    def at(self, ros_ns: int) -> int:
        """Return mission time at a moment of ROS time, ns; before the first tick they are equal."""
        if self._read_ns is None:
            return ros_ns
        return max(ros_ns, self._read_ns) + self._behind_ns

    def advance(self, ros_ns: int) -> int:
        """Return mission time at a tick, ns. A jump of the clock is detected here."""
        before_ns = self._read_ns
        self._read_ns = ros_ns
        if before_ns is not None and ros_ns < before_ns:
            self._behind_ns += before_ns - ros_ns
        if before_ns and not 0 <= ros_ns - before_ns < LEAP_NS:  # 0 was no time yet
            self._on_jump((ros_ns - before_ns) / 1e9)
        return ros_ns + self._behind_ns
