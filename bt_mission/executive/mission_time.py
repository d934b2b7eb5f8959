"""The time that a mission lives through, from a clock that may be set.

ROS time is the clock of whoever publishes ``/clock``, or of this machine. A simulator that is reset
sets it back, and then whatever waits for an instant would wait for all that time once more. So a
mission goes on from where it was: its time never goes back, and of every limit there is left
what was left before. Time that is skipped has passed, as for everybody else in the graph.
"""

from __future__ import annotations

from collections.abc import Callable

LEAP_NS = 5_000_000_000
"""Between two readings; less may be a slow publisher of ``/clock``, or a fast simulation."""


class MissionTime:
    """Mission time, from readings of ROS time.

    Args:
        on_jump: Told of each jump of the clock, in seconds; below zero it was set back.
    """

    def __init__(self, on_jump: Callable[[float], None]) -> None:
        self._on_jump = on_jump
        self._read_ns: int | None = None
        self._behind_ns = 0

    def at(self, ros_ns: int) -> int:
        """Mission time at a moment of ROS time, ns; before the first tick they are one."""
        if self._read_ns is None:
            return ros_ns
        return max(ros_ns, self._read_ns) + self._behind_ns

    def advance(self, ros_ns: int) -> int:
        """Mission time at a tick, ns; a clock that was set is seen here."""
        before_ns = self._read_ns
        self._read_ns = ros_ns
        if before_ns is not None and ros_ns < before_ns:
            self._behind_ns += before_ns - ros_ns
        if before_ns and not 0 <= ros_ns - before_ns < LEAP_NS:  # 0 was no time yet
            self._on_jump((ros_ns - before_ns) / 1e9)
        return ros_ns + self._behind_ns
