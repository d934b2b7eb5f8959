"""The thin layers between a mission's leaves and rclpy's publisher, and its client of a service."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rclpy.node import Node
from rclpy.task import Future

from bt_mission.base.dds.liveliness import RECORDER
from bt_mission.ros.graph import REQUESTS
from bt_mission.ros.interface_types import check_type, fill, message_type, service_type

DEPTH = 10


class RosClient:
    """A client of one name in the graph, with messages of one type.

    Args:
        node: The node of the client.
        name: The full name.
        type_name: Such as ``std_msgs/msg/Bool``.
        make: Makes a message to send.
        known: Names in the graph, each with its types.

    Raises:
        BtMissionError: The graph has that name with another type.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        type_name: str,
        make: Callable[[], Any],
        known: Iterable[tuple[str, list[str]]],
    ) -> None:
        self._node = node
        self.name = name
        self.type_name = type_name
        self._make = make
        check_type(name, type_name, dict(known).get(name, ()))

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """Return a message, request or goal with these fields.

        Raises:
            BtMissionError: A value does not fit its field.
        """
        return fill(self._make(), fields)


class TopicPublisher(RosClient):
    """Publishes on one topic, reliable and volatile.

    Raises also for a type that is not installed.
    """

    def __init__(self, node: Node, name: str, type_name: str) -> None:
        kind, full = message_type(type_name), node.resolve_topic_name(name)
        super().__init__(node, full, type_name, kind, node.get_topic_names_and_types())
        self._publisher = node.create_publisher(kind, name, DEPTH)

    def close(self) -> None:
        """Destroy the publisher."""
        self._node.destroy_publisher(self._publisher)

    def count_readers(self) -> int:
        """Return the number of matched subscriptions, without those of recorders."""
        matched = int(self._publisher.get_subscription_count())
        if matched == 0:
            return 0
        readers = self._node.get_subscriptions_info_by_topic(self.name)
        recorders = sum(1 for reader in readers if reader.node_name == RECORDER)
        return max(0, matched - recorders)

    def publish(self, message: Any) -> None:
        """Send a message."""
        self._publisher.publish(message)


class RosServiceClient(RosClient):
    """Calls one service. Raises also for a type that is not installed."""

    def __init__(self, node: Node, name: str, type_name: str) -> None:
        kind, full = service_type(type_name), node.resolve_service_name(name)
        super().__init__(node, full, type_name, kind.Request, node.get_service_names_and_types())
        self._client = node.create_client(kind, name, qos_profile=REQUESTS)

    def close(self) -> None:
        """Destroy the client."""
        self._node.destroy_client(self._client)

    def is_ready(self) -> bool:
        """Return whether a server is in the graph, and matched."""
        return bool(self._client.service_is_ready())

    def call(self, request: Any, on_answer: Callable[[Any], None]) -> Callable[[], None]:
        """Send a request. Return a function that drops it; later responses are ignored."""
        future: Future = self._client.call_async(request)
        future.add_done_callback(lambda done: on_answer(done.result()))
        return lambda: self._client.remove_pending_request(future)
