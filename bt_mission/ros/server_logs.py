"""The warnings of action servers: the response that rejects a goal has no reason."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import Log
from rclpy.node import Node
from rclpy.qos import QoSProfile

ROSOUT = "/rosout"
ROSOUT_DEPTH = 50

FEEDBACK = "/_action/feedback"
"""A publisher of this topic of an action serves the action."""


@dataclass
class _Ear:
    """The newest warning of the servers of an action, and how many there were."""

    action: str
    words: str = ""
    count: int = 0


class ServerLogs:
    """Hears on ``/rosout`` what servers warn of.

    Args:
        node: Owns the subscription.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._ears: dict[str, _Ear] = {}
        self._subscription = node.create_subscription(
            Log, ROSOUT, self._take, QoSProfile(depth=ROSOUT_DEPTH)
        )

    def close(self) -> None:
        """Hear no more."""
        self._node.destroy_subscription(self._subscription)

    def listen(self, action: str) -> Callable[[], str]:
        """Return a reader of the newest warning of an action's servers; empty without one.

        Args:
            action: The resolved name.
        """
        ear = self._ears.setdefault(action, _Ear(action))
        before = ear.count
        return lambda: ear.words if ear.count > before else ""

    def _take(self, message: Any) -> None:
        if message.level < Log.WARN:
            return
        for ear in self._ears.values():
            if any(_is_of(message.name, server) for server in self._servers(ear.action)):
                ear.words, ear.count = message.msg, ear.count + 1

    def _servers(self, action: str) -> set[str]:
        """The names of loggers of the nodes that serve an action."""
        return {
            f"{publisher.node_namespace}/{publisher.node_name}".strip("/").replace("/", ".")
            for publisher in self._node.get_publishers_info_by_topic(action + FEEDBACK)
        }


def _is_of(logger: str, server: str) -> bool:
    return logger == server or logger.startswith(f"{server}.")
