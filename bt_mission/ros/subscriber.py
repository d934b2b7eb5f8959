"""Messages of one topic for listeners, whatever quality of service they are sent with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from bt_mission.base.diagnostics import listed
from bt_mission.ros.interface_types import check_type, message_type

ANY_PUBLISHER = QoSProfile(
    depth=10, reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.VOLATILE
)
"""The least demanding profile, which matches every publisher."""

LATCHED_PUBLISHER = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
"""Also brings what was published before."""


def matching_qos(offers: Sequence[QoSProfile], depth: int) -> QoSProfile:
    """Return the best profile that all publishers offer: reliable and latched only if each is.

    Args:
        offers: The offer of each; without any, the least demanding profile.
        depth: The number of messages that may wait.
    """
    is_reliable = {offer.reliability for offer in offers} == {ReliabilityPolicy.RELIABLE}
    is_latched = {offer.durability for offer in offers} == {DurabilityPolicy.TRANSIENT_LOCAL}
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE,
    )


class LatestMessageSubscriber:
    """Subscribes once, and hands each message to those who listen at the moment.

    A second subscription is made where a latched publisher is in the graph; not otherwise,
    because the publishers of other topics would warn of it. Then a message comes twice.

    Args:
        node: Owns the subscriptions.
        topic: The topic's name; resolved against the node's namespace.
        type_name: Such as ``std_msgs/msg/Bool``.

    Raises:
        BtMissionError: When the type is not installed, or the topic has another one.
    """

    _is_raw = False

    def __init__(self, node: Node, topic: str, type_name: str) -> None:
        self._node = node
        self._type_name = type_name
        self._type = message_type(type_name)
        self._listeners: list[Callable[[Any], None]] = []
        self._latched: Any = None
        self._hears_latched = False
        self.name = node.resolve_topic_name(topic)
        self._subscriptions: list[Any] = []
        check_type(self.name, type_name, self._published_types(), "is published as")
        self.look_around()
        self._subscriptions.append(
            node.create_subscription(
                self._type, topic, self._hand_on, ANY_PUBLISHER, raw=self._is_raw
            )
        )

    def close(self) -> None:
        """Destroy the subscriptions."""
        while self._subscriptions:
            self._node.destroy_subscription(self._subscriptions.pop())

    def listen(self, listener: Callable[[Any], None]) -> None:
        """Pass messages to this listener from now on; the newest latched one at once."""
        self._listeners.append(listener)
        if self._latched is not None:
            listener(self._latched)

    def leave(self, listener: Callable[[Any], None]) -> None:
        """Hand nothing more to this listener."""
        if listener in self._listeners:
            self._listeners.remove(listener)

    def look_around(self) -> None:
        """Subscribe to the history of a latched publisher, once there is one in the graph."""
        if self._hears_latched:
            return
        publishers = self._node.get_publishers_info_by_topic(self.name)
        if any(
            publisher.qos_profile.durability is DurabilityPolicy.TRANSIENT_LOCAL
            and publisher.qos_profile.reliability is ReliabilityPolicy.RELIABLE
            and publisher.topic_type == self._type_name
            for publisher in publishers
        ):
            self._hears_latched = True
            latched = self._node.create_subscription(
                self._type,
                self.name,
                self._keep,
                LATCHED_PUBLISHER,
                # Another publisher of the topic may not be latched, and need not.
                event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
                raw=self._is_raw,
            )
            self._subscriptions.append(latched)

    def why_silent(self) -> str:
        """Return what the graph shows of the topic's publishers, as text."""
        types = self._published_types()
        if not types:
            return "it has no publisher"
        if self._type_name not in types:
            return f"it is published as {listed(types)}, not as {self._type_name}"
        return "its publishers are silent"

    def _published_types(self) -> list[str]:
        publishers = self._node.get_publishers_info_by_topic(self.name)
        return sorted({publisher.topic_type for publisher in publishers})

    def _keep(self, message: Any) -> None:
        self._latched = message
        self._hand_on(message)

    def _hand_on(self, message: Any) -> None:
        for listener in tuple(self._listeners):
            listener(message)


class SerializedSubscriber(LatestMessageSubscriber):
    """Passes on the bytes of messages, for listeners that only need their arrival."""

    _is_raw = True


SubscriberKind: TypeAlias = type[LatestMessageSubscriber]
