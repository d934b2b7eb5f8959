"""The thin layers between a mission's leaves and rclpy's publisher, and its client of a service."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.node import Node
from rclpy.task import Future

from bt_mission.core.dds.liveliness import RECORDER
from bt_mission.ros.interface_types import check_type, fill, message_type, service_type

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


class RosServiceClient:
    """Carries requests to the server of one service, and answers back.

    Args:
        node: Owns the client.
        name: The service's name; resolved against the node's namespace.
        type_name: Such as ``std_srvs/srv/Trigger``.

    Raises:
        BtMissionError: When the type is not installed, or the service has another one.
    """

    def __init__(self, node: Node, name: str, type_name: str) -> None:
        self._type = service_type(type_name)
        self.name = node.resolve_service_name(name)
        check_type(
            self.name, type_name, dict(node.get_service_names_and_types()).get(self.name, ())
        )
        self._node = node
        self._client = node.create_client(self._type, name)

    def close(self) -> None:
        """Destroy the client."""
        self._node.destroy_client(self._client)

    def is_ready(self) -> bool:
        """Is a server in the graph, and matched?"""
        return bool(self._client.service_is_ready())

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """A request with these fields.

        Raises:
            BtMissionError: When a value does not fit its field.
        """
        return fill(self._type.Request(), fields)

    def call(self, request: Any, on_answer: Callable[[Any], None]) -> Callable[[], None]:
        """Send a request; gives a function that forgets it, after which no answer is heard."""
        future: Future = self._client.call_async(request)
        future.add_done_callback(lambda done: on_answer(done.result()))
        return lambda: self._client.remove_pending_request(future)
