"""An executor with nodes made on demand."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node

from bt_mission.ros.graph import destroy_actions
from bt_mission.virtual_time import VirtualTimeExecutor


class Rig:
    """An executor with nodes made on demand."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.executor = VirtualTimeExecutor(context=context)
        self.nodes: list[Node] = []

    def node(self, name: str) -> Node:
        node = Node(name, context=self.context, enable_rosout=False, start_parameter_services=False)
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def now(self, node: Node) -> int:
        return int(node.get_clock().now().nanoseconds)

    def steps_until(self, time_ns: int) -> None:
        while self.executor.next_due_ns() <= time_ns:
            self.executor.step()


@pytest.fixture
def rig() -> Iterator[Rig]:
    """An executor in a context of its own."""
    context = Context()
    rclpy.init(context=context)
    rig = Rig(context)
    yield rig
    for node in rig.nodes:
        node.destroy_node()
        destroy_actions(node)
    rig.executor.shutdown()
    context.shutdown()
