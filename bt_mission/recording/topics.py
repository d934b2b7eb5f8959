"""The topics of a graph: found, and taken as they are sent, serialized.

Publishers of nodes of this process are tapped; what others send comes by raw subscriptions.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message

from bt_mission.core.cdr.decoder import Take
from bt_mission.core.diagnostics import listed
from bt_mission.core.errors import BtMissionError
from bt_mission.ros.graph import ProcessNode
from bt_mission.ros.interface_types import action_type, message_type
from bt_mission.ros.subscriber import matching_qos

if TYPE_CHECKING:
    from rclpy.duration import Duration
    from rclpy.node import Node

DEPTH = 1000
"""Messages of a topic that may wait until they are taken."""

FEEDBACK_TYPE = "_FeedbackMessage"


class Opening(Protocol):
    """What decides what becomes of a topic."""

    def open_topic(self, topic: str, type_name: str, offered_qos: str) -> Take | None:
        """Give who takes the topic's messages, if any; `offered_qos` as rosbag2 writes it."""

    def guarded(self, call: Callable[..., None]) -> Callable[..., None]:
        """Give ``call`` without its exceptions."""

    def trimming(self, type_name: str, *, has_one_shape: bool) -> Callable[[Take], Take] | None:
        """Give what takes from messages what rclpy adds to them; None where that takes too long."""


@dataclass(frozen=True)
class _Subscribed:
    message_class: Any
    take_message: Callable[..., Any]
    take: Take
    action: str
    """That it is a topic of, if any."""


class GraphTopics:
    """Takes the messages of every topic that somebody publishes.

    Args:
        node: Owns the subscriptions. Where an executor serves it, messages come through it;
            :meth:`poll` takes them otherwise.
        opening: Decides what becomes of a topic.
        skip: Topics to leave alone.
        inside: Gives the nodes whose publishers are tapped.
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
        self._tappable: set[str] = set()
        self._publishers: set[Publisher] = set()
        self._tapped: list[Publisher] = []
        self._subscribed: list[_Subscribed] = []
        self.faults: dict[str, str] = {}
        """Why a topic is not taken, by its name."""

    def look_around(self) -> None:
        """Take in what has come up since the last time."""
        for one in self._inside():
            for publisher in one.node.publishers:
                if publisher not in self._publishers:
                    self._publishers.add(publisher)
                    self._tap(publisher, one)
        for topic, types in self._node.get_topic_names_and_types():
            if topic not in self._known:
                self._find(topic, types)

    def poll(self, busy: Container[str] | None = None) -> None:
        """Hand on what has come by subscriptions, topic by topic.

        Args:
            busy: Of the topics of actions, look only at those of these actions.
        """
        for one in self._subscribed:
            if busy is not None and one.action and one.action not in busy:
                continue
            # Without the handle's context manager, which guards against destruction: nobody else
            # destroys these, and a look into an empty queue takes 0.6 us this way.
            while (taken := one.take_message(one.message_class, True)) is not None:
                one.take(taken[0])

    def close(self) -> None:
        """Let go of the publishers; the subscriptions go with the node."""
        for publisher in self._tapped:
            untap(publisher)
        self._tapped.clear()

    def _tap(self, publisher: Publisher, by: ProcessNode) -> None:
        topic, type_name = publisher.topic_name, name_of(publisher.msg_type)
        if topic in self._skip or (topic in self._known and topic not in self._tappable):
            return
        try:
            trim = self._opening.trimming(type_name, has_one_shape=by.is_sensor)
            if trim is None:
                return
            self._known.add(topic)
            self._tappable.add(topic)
            offer = offered([publisher.qos_profile])
            take = self._opening.open_topic(topic, type_name, offer)
        except BtMissionError as error:
            self.faults[topic] = str(error)
            return
        if take is not None:
            trimmed = trim(take)
            if trimmed is not take:
                take = self._opening.guarded(trimmed)
            tap(publisher, take, counts=by.is_sensor)
            self._tapped.append(publisher)

    def _find(self, topic: str, types: list[str]) -> None:
        offers = [one.qos_profile for one in self._node.get_publishers_info_by_topic(topic)]
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
        message_class = class_of(type_name)
        take = self._opening.open_topic(topic, type_name, offered(offers))
        if take is None:
            return
        subscription = self._node.create_subscription(
            message_class,
            topic,
            take,
            matching_qos(offers, DEPTH),
            raw=True,
            # A publisher that comes later may offer less; the others are heard all the same.
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
        )
        action, is_part, _ = topic.partition("/_action/")
        self._subscribed.append(
            _Subscribed(
                message_class,
                subscription.handle.take_message,
                take,
                action if is_part else "",
            )
        )


def class_of(type_name: str) -> Any:
    """Return the class of a topic's type, also of an action's feedback. Raises UnknownType."""
    if "/action/" in type_name and type_name.endswith(FEEDBACK_TYPE):
        return action_type(type_name.removesuffix(FEEDBACK_TYPE)).Impl.FeedbackMessage
    return message_type(type_name)


def name_of(message_class: Any) -> str:
    """Return the full name of a message's type."""
    package, folder, *_ = message_class.__module__.split(".")
    return f"{package}/{folder}/{message_class.__name__}"


def offered(offers: Iterable[QoSProfile]) -> str:
    """What publishers offer, as rosbag2 writes it down (YAML)."""
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


class Tapped(Publisher):
    """A publisher whose messages somebody takes before they are sent; made by :func:`tap`.

    A subscription would do, too, but costs twice as much: another reader for the middleware, and
    another look into a queue at every instant.
    """

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

    Args:
        counts: Be taken for a subscription, so that what is only sent to somebody is sent.
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
