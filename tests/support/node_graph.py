"""Nodes on a virtual clock, to try the executive's side of ROS with."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node

from bt_mission.virtual_time import VirtualTimeExecutor
from bt_mission.virtual_time.discovery import pause


class Graph:
    """Nodes of one process, served until quiet."""

    def __init__(self, context: Context, stack: ExitStack) -> None:
        self._context = context
        self._stack = stack
        self._executor = VirtualTimeExecutor(context=context)
        stack.callback(self._executor.shutdown)

    def node(self, name: str) -> Node:
        node = Node(
            name, context=self._context, enable_rosout=False, start_parameter_services=False
        )
        self._stack.callback(node.destroy_node)
        self._executor.add_node(node)
        return node

    def settle(self, condition: Callable[[], bool] = lambda: True) -> None:
        """Serve until quiet, and until a condition holds."""
        for _ in range(2000):
            self._executor.run_until_quiet()
            if condition():
                return
            pause(self._context)  # latched messages come by a thread of the middleware
        raise AssertionError("it never came")


@pytest.fixture
def graph() -> Iterator[Graph]:
    """A graph in a context of its own."""
    with ExitStack() as stack:
        context = Context()
        rclpy.init(context=context)
        stack.callback(context.shutdown)
        yield Graph(context, stack)
