"""Watches over the executives: when one dies, the base is not to drive on for nobody."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import LivelinessPolicy, QoSProfile
from std_msgs.msg import Empty

from bt_mission.core.dds.liveliness import LEASE_S, TOPIC

PRESENCE = QoSProfile(
    depth=1,
    liveliness=LivelinessPolicy.AUTOMATIC,
    liveliness_lease_duration=Duration(nanoseconds=round(LEASE_S * 1e9)),
)


def watch_executives(node: Node, on_lost: Callable[[str], None]) -> None:
    """Tell `on_lost` why, when an executive dies, and when the last one leaves.

    A client that is no executive of ours is not watched.
    """

    def changed(status: Any) -> None:
        if status.not_alive_count_change > 0:
            on_lost(f"the executive has died: no sign of life for {LEASE_S:g} s")
        elif status.alive_count_change < 0 and status.alive_count == 0:
            on_lost("the executive has left")

    events = SubscriptionEventCallbacks(liveliness=changed, use_default_callbacks=False)
    node.create_subscription(Empty, TOPIC, lambda _: None, PRESENCE, event_callbacks=events)
