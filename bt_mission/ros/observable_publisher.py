"""Publishers whose messages somebody may look at before they are sent, and nodes that make them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy
from rclpy.serialization import serialize_message
from rclpy.subscription import Subscription


class ObservablePublisher(Publisher):
    """A publisher with one optional observer, which gets each message serialized.

    A subscription would do, too, but costs twice as much: another reader for the middleware, and
    another check of a queue at every instant.
    """

    _take: Callable[[bytes], None] | None = None
    msg_type: Any
    _is_latched: bool
    get_subscription_count: Callable[[], int]
    """The number of subscriptions, and one more if its observer counts as one."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        # The inner function of rclpy's methods, which also check the kind of message.
        self._send: Callable[[bytes], None] = self.handle.publish_raw
        self._count: Callable[[], int] = self.handle.get_subscription_count
        self.get_subscription_count = self._count

    def observe(self, take: Callable[[bytes], None], *, counts: bool) -> None:
        """Have an observer take each message from now on.

        Args:
            counts: Be taken for a subscription, so that what is only sent to somebody is sent.
        """
        self._take = take
        self._is_latched = self.qos_profile.durability is not DurabilityPolicy.VOLATILE
        self.get_subscription_count = lambda: self._count() + counts

    def unobserve(self) -> None:
        """Let the observer go."""
        self._take, self.get_subscription_count = None, self._count

    def publish(self, msg: Any) -> None:
        """Send a message; while it is observed, only with another subscription, now or later."""
        take = self._take
        if take is None and type(msg) is bytes:
            self._send(msg)
            return
        if take is None or not isinstance(msg, (bytes, self.msg_type)):
            super().publish(msg)
            return
        data = msg if isinstance(msg, bytes) else serialize_message(msg)
        take(data)
        if self._is_latched or self._count():
            self._send(data)


class ObservableNode(Node):
    """A node with observable publishers; a base before another node's class.

    It makes no handlers of events such as incompatible QoS, a third of the cost of a publisher: the
    executor of a stage does not serve them. Nodes that join the stage keep theirs.
    """

    def create_publisher(self, *args: Any, **options: Any) -> Publisher:
        """Make an :class:`ObservablePublisher`, unless the caller asks for another class."""
        options.setdefault("publisher_class", ObservablePublisher)
        options.setdefault("event_callbacks", PublisherEventCallbacks(use_default_callbacks=False))
        return super().create_publisher(*args, **options)

    def create_subscription(self, *args: Any, **options: Any) -> Subscription:
        """Make a subscription without handlers of events, unless the caller has some."""
        none = SubscriptionEventCallbacks(use_default_callbacks=False)
        options.setdefault("event_callbacks", none)
        return super().create_subscription(*args, **options)
