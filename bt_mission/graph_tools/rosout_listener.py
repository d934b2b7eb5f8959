"""Why a server rejected a goal: ROS 2 has no words for it in the answer, but servers log them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rcl_interfaces.msg import Log
from rclpy.qos import QoSProfile

from bt_mission.core.text import escape_control
from bt_mission.graph_tools.graph_query import FEEDBACK

if TYPE_CHECKING:
    from rclpy.node import Node

DEPTH = 50


class RosoutListener:
    """Hears the warnings of the nodes that serve an action, from now on.

    :param node: owns the subscription to ``/rosout``.
    :param action: the action's full name.
    """

    def __init__(self, node: Node, action: str) -> None:
        self._node = node
        self._action = action
        self._last = ""
        node.create_subscription(Log, "/rosout", self._take, QoSProfile(depth=DEPTH))

    def why(self) -> str:
        """The newest warning of a server of the action; empty where it has not warned."""
        return self._last

    def _take(self, message: Any) -> None:
        if message.level < Log.WARN:
            return
        servers = {
            f"{one.node_namespace}/{one.node_name}".strip("/").replace("/", ".")
            for one in self._node.get_publishers_info_by_topic(self._action + FEEDBACK)
        }
        if any(message.name == name or message.name.startswith(f"{name}.") for name in servers):
            self._last = escape_control(message.msg)
