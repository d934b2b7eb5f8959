"""The check of the publishers of the robot's odometry: two robots are not driven as one."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node

from bt_mission.base.dds.publishers import duplicate_publishers, single_publisher_topics
from bt_mission.base.ros_log import log_of

WATCH_PERIOD_S = 0.5
"""Seconds between two looks."""


class PublisherWatch:
    """Checks whether topics of the robot have several publishers.

    Args:
        node: A node of the graph.
        odometry: The topic of odometry.
        on_fault: Called with each new reason.
    """

    def __init__(self, node: Node, odometry: str, on_fault: Callable[[str], None]) -> None:
        self._node = node
        self._odometry = odometry
        self._log = log_of(node)
        self._on_fault = on_fault
        self._fault: str | None = None
        node.create_timer(WATCH_PERIOD_S, self.look)

    def look(self) -> str | None:
        """Return why nothing may be driven, or None."""
        if not self._node.context.ok():
            return None
        fault, before = duplicate_publishers(self._node, self._odometry), self._fault
        self._fault = fault
        if fault is not None and fault != before:
            self._log.error(fault)
            self._on_fault(fault)
        elif fault is None and before is not None:
            topics = single_publisher_topics(self._node, self._odometry)
            self._log.info(f"each of {', '.join(topics)} has one publisher again")
        return fault
