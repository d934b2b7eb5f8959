"""What the publishers of this process send, taken where they send it.

A subscription would do, too, but costs twice as much: another reader for the middleware, and
another look into a queue at every instant.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy
from rclpy.serialization import serialize_message

from bt_mission.core.cdr.decoder import Take


class Tapped(Publisher):
    """A publisher whose messages somebody takes before they are sent; made by :func:`tap`."""

    take: Take
    counts: bool
    is_latched: bool
    send: Take
    count: Callable[[], int]

    def publish(self, msg: Any) -> None:
        """Have a message taken, and send it where somebody else hears it, or will."""
        data = msg if isinstance(msg, bytes) else serialize_message(msg)
        self.take(data)
        if self.is_latched or self.count():
            self.send(data)

    def get_subscription_count(self) -> int:
        """How many subscriptions it has, and one more where the tap counts as one."""
        return self.count() + self.counts


def tap(publisher: Publisher, take: Take, *, counts: bool) -> None:
    """Have ``take`` see what a publisher sends.

    :param counts: be taken for a subscription, so that what is only sent to somebody is sent.
    """
    # Nodes hold on to their publishers, so another object in its place will not do.
    publisher.__class__ = Tapped
    one: Any = publisher
    one.take, one.counts = take, counts
    one.is_latched = publisher.qos_profile.durability is not DurabilityPolicy.VOLATILE
    # What rclpy's own methods call in the end; they also ask what kind of message it is.
    one.send, one.count = publisher.handle.publish_raw, publisher.handle.get_subscription_count


def untap(publisher: Publisher) -> None:
    """Make it a publisher like others again."""
    publisher.__class__ = Publisher
