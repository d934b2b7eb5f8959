"""A live executor, with nodes made on demand."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node

from bt_mission.ros.executors.live import LiveExecutor
from bt_mission.ros.graph import destroy_actions

LONG_S = 30.0
"""A wait that only ends where something does not come at all, s."""


def value_of(message: Any) -> int:
    """What a message says."""
    return int(message.data)


def count_of(event: Any) -> int:
    """How often something has happened so far, by an event of the middleware."""
    return int(event.total_count)


class Live:
    """A live executor, with nodes made on demand."""

    def __init__(self) -> None:
        self.context = Context()
        rclpy.init(context=self.context)
        self.executor = LiveExecutor(context=self.context)
        self.nodes: list[Node] = []

    def node(self, name: str, **options: Any) -> Node:
        """A node that is served."""
        options = {"enable_rosout": False, "start_parameter_services": False, **options}
        node = Node(name, context=self.context, **options)
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def until(self, is_so: Callable[[], object]) -> None:
        """Serve until something is so; fails where nothing more comes."""
        while not is_so():
            assert self.executor.serve(LONG_S), "it never came"

    def close(self) -> None:
        """Take everything down."""
        for node in self.nodes:
            node.destroy_node()
            destroy_actions(node)
        self.executor.shutdown()
        self.context.try_shutdown()


@pytest.fixture
def live() -> Iterator[Live]:
    """In a context of its own."""
    made = Live()
    yield made
    made.close()
