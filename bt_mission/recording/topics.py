"""The topics of a graph: discovered, and recorded as they are sent, serialized.

Publishers of this process are observed where possible; messages of others arrive by raw
subscriptions.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import QoSProfile

from bt_mission.base.diagnostics import listed
from bt_mission.base.errors import BtMissionError
from bt_mission.cdr.decoder import Take
from bt_mission.ros.graph import ProcessNode
from bt_mission.ros.interface_types import topic_type
from bt_mission.ros.observable_publisher import ObservablePublisher
from bt_mission.ros.subscriber import matching_qos

if TYPE_CHECKING:
    from rclpy.duration import Duration
    from rclpy.node import Node
    from rclpy.publisher import Publisher

DEPTH = 1000
"""Messages of a topic that may wait until they are taken."""


class Opening(Protocol):
    """Decides what is recorded of a topic."""

    def open_topic(self, topic: str, type_name: str, offered_qos: str) -> Take | None:
        """Return the receiver of a topic's messages, if any; `offered_qos` as in rosbag2."""

    def guarded(self, call: Callable[..., None]) -> Callable[..., None]:
        """Give ``call`` without its exceptions."""

    def trimming(self, type_name: str, *, has_fixed_shape: bool) -> Callable[[Take], Take] | None:
        """Return a function that removes rclpy's additions from messages; None if too slow."""


@dataclass(frozen=True)
class _Subscribed:
    message_class: Any
    take_message: Callable[..., Any]
    take: Take
    action: str
    """The action of the topic, if any."""
    is_feedback: bool

    def hand_on(self) -> None:
        """Pass on what was received."""
        # Without the handle's context manager, which guards against destruction: nobody else
        # destroys these, and a look into an empty queue takes 0.6 us this way.
        while (taken := self.take_message(self.message_class, True)) is not None:
            self.take(taken[0])


class GraphTopics:
    """Receives the messages of every topic that has a publisher.

    Args:
        node: Owns the subscriptions. Where an executor serves it, messages come through it;
            :meth:`poll` takes them otherwise.
        opening: Decides what is recorded of a topic.
        skip: Topics to ignore.
        inside: Returns the nodes whose publishers are observed, where possible.
    """

    def __init__(
        self,
        node: Node,
        opening: Opening,
        skip: Iterable[str],
        inside: Callable[[], Iterable[ProcessNode]],
    ) -> None:
        self._node = node
        self._opening = opening
        self._skip = frozenset(skip)
        self._inside = inside
        self._known = set(self._skip)
        self._observable: set[str] = set()
        self._hidden: set[str] = set()
        self._publishers: set[Publisher] = set()
        self._observed: list[ObservablePublisher] = []
        self._subscribed: list[_Subscribed] = []
        self.faults: dict[str, str] = {}
        """Why a topic is not taken, by its name."""

    def look_around(self) -> None:
        """Find new publishers and topics."""
        new = []
        for entities in self._inside():
            for publisher in entities.node.publishers:
                if publisher not in self._publishers:
                    self._publishers.add(publisher)
                    if isinstance(publisher, ObservablePublisher):
                        new.append((publisher, entities))
                    else:
                        self._subscribe_from_now_on(publisher.topic_name)
        for publisher, entities in new:
            self._observe(publisher, entities)
        for topic, types in self._node.get_topic_names_and_types():
            if topic not in self._known:
                self._find(topic, types)

    def poll(self, busy: Container[str] | None = None) -> None:
        """Pass on what subscriptions received, topic by topic.

        Args:
            busy: Of the topics of actions, only those of these actions.
        """
        for subscribed in self._subscribed:
            if busy is None or not subscribed.action or subscribed.action in busy:
                subscribed.hand_on()

    def poll_feedback(self, busy: Container[str]) -> None:
        """Pass on received feedback of these actions."""
        for subscribed in self._subscribed:
            if subscribed.is_feedback and subscribed.action in busy:
                subscribed.hand_on()

    def close(self) -> None:
        """Stop observing the publishers; the subscriptions end with the node."""
        for publisher in self._observed:
            publisher.unobserve()
        self._observed.clear()

    def _subscribe_from_now_on(self, topic: str) -> None:
        """Receive a topic only by a subscription, since a publisher of it cannot be observed."""
        if topic in self._skip or (topic in self._known and topic not in self._observable):
            return
        self._observable.discard(topic)
        self._hidden.add(topic)
        self._known.discard(topic)
        for publisher in self._observed:
            if publisher.topic_name == topic:
                publisher.unobserve()

    def _observe(self, publisher: ObservablePublisher, by: ProcessNode) -> None:
        topic, type_name = publisher.topic_name, name_of(publisher.msg_type)
        if topic in self._skip or topic in self._hidden:
            return
        if topic in self._known and topic not in self._observable:
            return
        try:
            trim = self._opening.trimming(type_name, has_fixed_shape=by.is_sensor)
            if trim is None:
                return
            self._known.add(topic)
            self._observable.add(topic)
            offer = offered([publisher.qos_profile])
            take = self._opening.open_topic(topic, type_name, offer)
        except BtMissionError as error:
            self.faults[topic] = str(error)
            return
        if take is not None:
            trimmed = trim(take)
            if trimmed is not take:
                take = self._opening.guarded(trimmed)
            publisher.observe(take, counts=by.is_sensor)
            self._observed.append(publisher)

    def _find(self, topic: str, types: list[str]) -> None:
        offers = [info.qos_profile for info in self._node.get_publishers_info_by_topic(topic)]
        if not offers:
            return
        self._known.add(topic)
        if len(types) > 1:
            self.faults[topic] = f"it has several types: {listed(sorted(types))}"
            return
        try:
            self._subscribe(topic, types[0], offers)
        except BtMissionError as error:
            self.faults[topic] = str(error)

    def _subscribe(self, topic: str, type_name: str, offers: list[QoSProfile]) -> None:
        message_class = topic_type(type_name)
        take = self._opening.open_topic(topic, type_name, offered(offers))
        if take is None:
            return
        subscription = self._node.create_subscription(
            message_class,
            topic,
            take,
            matching_qos(offers, DEPTH),
            raw=True,
            # A later publisher may offer less; the others are still received.
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
        )
        action, is_part, part = topic.partition("/_action/")
        self._subscribed.append(
            _Subscribed(
                message_class,
                subscription.handle.take_message,
                take,
                action if is_part else "",
                part == "feedback",
            )
        )


def name_of(message_class: Any) -> str:
    """Return the full name of a message's type."""
    package, folder, *_ = message_class.__module__.split(".")
    return f"{package}/{folder}/{message_class.__name__}"


def offered(offers: Iterable[QoSProfile]) -> str:
    """Return the QoS that publishers offer, as rosbag2 writes it (YAML)."""
    return "".join(
        f"- history: {qos.history.name.lower()}\n"
        f"  depth: {qos.depth}\n"
        f"  reliability: {qos.reliability.name.lower()}\n"
        f"  durability: {qos.durability.name.lower()}\n"
        f"  deadline: {_span(qos.deadline)}\n"
        f"  lifespan: {_span(qos.lifespan)}\n"
        f"  liveliness: {qos.liveliness.name.lower()}\n"
        f"  liveliness_lease_duration: {_span(qos.liveliness_lease_duration)}\n"
        "  avoid_ros_namespace_conventions: "
        f"{str(qos.avoid_ros_namespace_conventions).lower()}\n"
        for qos in offers
    )


def _span(duration: Duration) -> str:
    seconds, nanoseconds = divmod(duration.nanoseconds, 1_000_000_000)
    return f"{{sec: {seconds}, nsec: {nanoseconds}}}"
