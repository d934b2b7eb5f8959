"""The ROS clocks of nodes, kept at virtual time. A fault can set a clock wrong."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rclpy.clock_type import ClockType
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.time import Time


class Clocks:
    """Sets the clocks of nodes.

    A clock that was set wrong continues from there. The node's timers follow their clock, and fire
    as rclpy lets them do when ``/clock`` jumps.
    """

    def __init__(self) -> None:
        self.stopped: frozenset[Node] = frozenset()
        """The nodes with a stopped clock: none of their timers is ever due."""
        self._ahead_ns: dict[Node, int] = {}
        self._stopped_ns: dict[Node, int] = {}
        self._handles: list[tuple[Node, Any]] = []
        self._others: list[Any] = []
        self._kept: frozenset[int] = frozenset()

    def start(self, node: Node, now_ns: int) -> None:
        """Control a node's clock from now on. Its timers restart."""
        handle = node.get_clock().handle
        with handle:
            handle.set_ros_time_override_is_enabled(True)
        self._set(node, now_ns)
        for timer in node.timers:
            timer.reset()

    def keep(self, nodes: Iterable[Node]) -> None:
        """Take note of the nodes whose clocks :meth:`set_time` sets."""
        self._handles = [(node, node.get_clock().handle) for node in nodes]
        own = {id(handle) for _, handle in self._handles}
        others = [timer.clock.handle for node, _ in self._handles for timer in node.timers]
        self._others = [handle for handle in others if id(handle) not in own]
        self._kept = frozenset(own | {id(handle) for handle in self._others})

    def keeps(self, handle: Any) -> bool:
        """Return whether :meth:`set_time` sets a clock."""
        return id(handle) in self._kept

    def set_time(self, now_ns: int) -> None:
        """Set the clocks of all nodes to virtual time, ns."""
        time = _rclpy.rcl_time_point_t(now_ns, ClockType.ROS_TIME)
        for handle in self._others:
            with handle:
                handle.set_ros_time_override(time)
        if self._ahead_ns:
            for node, _ in self._handles:
                self._set(node, now_ns)
            return
        for _, handle in self._handles:
            with handle:
                handle.set_ros_time_override(time)

    def _set(self, node: Node, now_ns: int) -> None:
        handle = node.get_clock().handle
        with handle:
            handle.set_ros_time_override(_ros_time(self.at(node, now_ns))._time_handle)

    def at(self, node: Node, now_ns: int) -> int:
        """Return the time of a node's clock at virtual time ``now_ns``, ns."""
        return self._stopped_ns.get(node, now_ns) + self._ahead_ns.get(node, 0)

    def set_ahead(self, node: Node, by_ns: int, now_ns: int) -> None:
        """Advance a node's clock by an offset, ns; a negative one sets it back."""
        self._ahead_ns[node] = self._ahead_ns.get(node, 0) + by_ns
        self._set(node, now_ns)

    def stop(self, node: Node, now_ns: int) -> None:
        """Stop a node's clock."""
        self._ahead_ns.setdefault(node, 0)
        self._stopped_ns.setdefault(node, now_ns)
        self.stopped = frozenset(self._stopped_ns)

    def go_on(self, node: Node, now_ns: int) -> None:
        """Let a stopped clock continue."""
        stopped_ns = self._stopped_ns.pop(node, now_ns)
        self.stopped = frozenset(self._stopped_ns)
        self._ahead_ns[node] -= now_ns - stopped_ns


def _ros_time(time_ns: int) -> Time:
    return Time(nanoseconds=time_ns, clock_type=ClockType.ROS_TIME)
