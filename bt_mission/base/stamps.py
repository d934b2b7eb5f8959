"""Stamps and durations of ROS messages as numbers: `builtin_interfaces/Time` and `Duration`."""

from __future__ import annotations

from typing import Any

NS = 1_000_000_000
"""Nanoseconds in a second."""

MOST_SECONDS = 2**31 - 1
"""The seconds that a time of ROS can hold, 68 years: `sec` in `builtin_interfaces` is an int32."""


def to_ns(stamp: Any) -> int:
    """Return a Time or a Duration in ns."""
    return int(stamp.sec) * NS + int(stamp.nanosec)


def clock_ns(clock: Any) -> int:
    """Return the time of an rclpy clock, ns, without making a Time of it."""
    handle = clock.handle
    with handle:
        return int(handle.get_now().nanoseconds)


def set_ns(stamp: Any, time_ns: int) -> Any:
    """Set a Time or a Duration to a number of ns, and return it."""
    stamp.sec, stamp.nanosec = divmod(time_ns, NS)
    return stamp
