"""Subscriptions that suit whatever the publishers of a topic offer."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from bt_mission.ros.interface_types import message_type

if TYPE_CHECKING:
    from rclpy.node import Node

    from bt_mission.graph_tools.graph_session import GraphSession

DEPTH = 100

NS = 1_000_000_000


def fitting(node: Node, topic: str, depth: int = DEPTH) -> QoSProfile:
    """The most that every publisher of the topic offers: reliable and latched only if all are."""
    offered = [one.qos_profile for one in node.get_publishers_info_by_topic(topic)]
    reliable = bool(offered) and all(
        one.reliability is ReliabilityPolicy.RELIABLE for one in offered
    )
    latched = bool(offered) and all(
        one.durability is DurabilityPolicy.TRANSIENT_LOCAL for one in offered
    )
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=(DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE),
    )


class Listener:
    """Subscribes to a topic, and anew when its publishers offer something else.

    :param hand: its node owns the subscription.
    :param topic: full name.
    :param type_name: such as ``std_msgs/msg/Bool``. Raises UnknownType.
    :param take: called with each message, or its bytes.
    :param raw: do not unpack messages.
    """

    def __init__(
        self,
        hand: GraphSession,
        topic: str,
        type_name: str,
        take: Callable[[Any], None],
        *,
        raw: bool = False,
    ) -> None:
        self._hand = hand
        self._topic = topic
        self._type = message_type(type_name)
        self._take = take
        self._raw = raw
        self._subscribe(fitting(hand.node, topic))
        self._next_look_ns = hand.now_ns + NS

    def step(self) -> None:
        """Serve what comes next; once a second, look whether the publishers are other ones."""
        self._hand.step()
        if self._hand.now_ns >= self._next_look_ns:
            self._next_look_ns = self._hand.now_ns + NS
            wanted = fitting(self._hand.node, self._topic)
            if self._hand.node.count_publishers(self._topic) and wanted != self._qos:
                self._hand.node.destroy_subscription(self._subscription)
                self._subscribe(wanted)

    def _subscribe(self, qos: QoSProfile) -> None:
        self._qos = qos
        self._subscription = self._hand.node.create_subscription(
            self._type, self._topic, self._take, qos, raw=self._raw
        )
