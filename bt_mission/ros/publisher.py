"""Messages for one topic: the thin layer between a mission's leaf and rclpy's publisher."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bt_mission.core.dds.liveliness import RECORDER
from bt_mission.ros.interface_types import check_type, fill, message_type

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rclpy.node import Node

DEPTH = 10


class TopicPublisher:
    """Publishes on one topic, reliable and volatile.

    Args:
        node: Owns the publisher.
        name: The topic's name; resolved against the node's namespace.
        type_name: Such as ``std_msgs/msg/Bool``.

    Raises:
        BtMissionError: When the type is not installed, or the topic has another one.
    """

    def __init__(self, node: Node, name: str, type_name: str) -> None:
        self._node = node
        self._type = message_type(type_name)
        self.name = node.resolve_topic_name(name)
        check_type(self.name, type_name, dict(node.get_topic_names_and_types()).get(self.name, ()))
        self._publisher = node.create_publisher(self._type, name, DEPTH)

    def close(self) -> None:
        """Destroy the publisher."""
        self._node.destroy_publisher(self._publisher)

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """A message with these fields.

        Raises:
            BtMissionError: When a value does not fit its field.
        """
        return fill(self._type(), fields)

    def count_readers(self) -> int:
        """How many subscriptions are matched; that of a recorder does not count."""
        matched = int(self._publisher.get_subscription_count())
        if matched == 0:
            return 0
        found = self._node.get_subscriptions_info_by_topic(self.name)
        recorders = sum(1 for one in found if one.node_name == RECORDER)
        return max(0, matched - recorders)

    def publish(self, message: Any) -> None:
        """Send a message."""
        self._publisher.publish(message)
