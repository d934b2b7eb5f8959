"""A node that leaves the graph takes its actions with it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rclpy.action import ActionClient, ActionServer

if TYPE_CHECKING:
    from rclpy.node import Node


def destroy_actions(node: Node) -> None:
    """Destroy the action clients and servers that a node has not destroyed itself.

    rclpy leaves them alive, and the whole DDS participant with them, until the garbage collector
    comes by: a process that makes many nodes runs out of the ports of its domain.
    """
    for waitable in tuple(node.waitables):
        if isinstance(waitable, ActionClient | ActionServer):
            waitable.destroy()  # type: ignore[no-untyped-call]
