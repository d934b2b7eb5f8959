"""Nodes on one virtual clock."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import rclpy
from rclpy.context import Context
from rclpy.node import Node

from bt_mission.ros.graph import destroy_actions
from bt_mission.ros.virtual_time import VirtualTimeExecutor
from bt_mission.ros.virtual_time.discovery import pause

LEAN: dict[str, Any] = {"enable_rosout": False, "start_parameter_services": False}

OneNode = TypeVar("OneNode", bound=Node)


class Rig:
    """Nodes on one virtual clock, which belong to a context of their own.

    Args:
        ros_args: For all nodes.
        start_ns: Where time begins.
    """

    def __init__(self, ros_args: Sequence[str] = (), start_ns: int = 1_000_000_000) -> None:
        self.context = Context()
        rclpy.init(context=self.context, args=["--ros-args", *ros_args] if ros_args else None)
        self.start_ns = start_ns
        self.clock = VirtualTimeExecutor(start_ns=start_ns, context=self.context)
        self.nodes: list[Node] = []

    def close(self) -> None:
        """Destroy all nodes that are served, and all bare ones; once."""
        if not self.context.ok():
            return
        for node in reversed(list(dict.fromkeys([*self.nodes, *self.clock.get_nodes()]))):
            node.destroy_node()
            destroy_actions(node)
        self.clock.shutdown()
        self.context.shutdown()

    def add(self, node: OneNode) -> OneNode:
        """Serve a node; gives it back."""
        self.clock.add_node(node)
        return node

    def node(self, name: str) -> Node:
        """Make a bare node."""
        self.nodes.append(self.add(Node(name, context=self.context, **LEAN)))
        return self.nodes[-1]

    def now(self, node: Node) -> int:
        """Return the time of a node's clock, ns."""
        return int(node.get_clock().now().nanoseconds)

    @property
    def now_s(self) -> float:
        """Virtual time since the start, s."""
        return (self.clock.now_ns - self.start_ns) / 1e9

    def step(self) -> None:
        """Go to the next instant."""
        self.clock.step()

    def steps_until(self, time_ns: int) -> None:
        """Go through all instants up to a time."""
        while self.clock.next_due_ns() <= time_ns:
            self.step()

    def run_for(self, seconds: float) -> None:
        """Let time pass."""
        end_ns = self.clock.now_ns + round(seconds * 1e9)
        while self.clock.now_ns < end_ns:
            self.step()

    def settle(self, condition: Callable[[], bool] = lambda: True) -> None:
        """Serve until quiet, and until a condition holds, at this instant."""
        for _ in range(2000):
            self.clock.run_until_quiet()
            if condition():
                return
            pause(self.context)  # latched messages come by a thread of the middleware
        raise AssertionError("it never came")
