"""The mission's node gives all leaves of a tick the same time."""

from __future__ import annotations

from typing import Any

from rclpy.clock_type import ClockType
from rclpy.time import Time


def test_time_stands_still_during_a_tick(ros: Any) -> None:
    """Even where the node's clock is set forward within it, as a graph's ``/clock`` might."""
    node = ros.mission("mission: m\ntree:\n  wait: 60\n")
    seen = []

    def move_on() -> None:
        later = Time(nanoseconds=node.now_ns + 1, clock_type=ClockType.ROS_TIME)
        node.node.get_clock().set_ros_time_override(later)
        seen.append(node.now_ns)

    before_ns = node.now_ns
    node.executive.after_tick.append(move_on)
    node.tick()
    assert (seen, node.now_ns) == ([before_ns], before_ns + 1)
