"""Calls of one service: the thin layer between a mission's leaf and rclpy's client."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bt_mission.ros.interface_types import check_type, fill, service_type

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rclpy.node import Node
    from rclpy.task import Future


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
