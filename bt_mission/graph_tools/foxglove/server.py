"""Serves topics over the WebSocket protocol of Foxglove, with its makers' own server.

A topic costs nothing until a client subscribes to it: only then is there a subscription in ROS, and
its messages are passed on as they came, serialized. The server writes to its clients from a thread
of its own, outside Python, and drops messages for a client that is slow.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import foxglove
from foxglove.websocket import Capability
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile

from bt_mission.core.cdr.definitions import Definitions, share_folders, with_plain_names
from bt_mission.core.dds.publishers import CLOCK
from bt_mission.core.diagnostics import listed
from bt_mission.core.errors import BtMissionError, described
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.ros.interface_types import topic_type
from bt_mission.ros.subscriber import matching_qos

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.subscription import Subscription

LOOPBACK, PORT = "127.0.0.1", 8765

SEARCH_S = 1.0
"""Wall time between two looks at what topics there are."""

TIME_S = 0.05
"""Wall time between two messages with the time of the graph."""

SETTLE_S = 0.2
"""Wall time after which messages reach a client of which the server has told that it subscribes."""

DEPTH = 100
"""Messages of a topic that may wait until they are taken."""

BACKLOG = 256
"""Messages that may wait for a client; the oldest are dropped where it is slower."""

NEVER = (CLOCK, "/parameter_events")
"""The time is told by the protocol itself; parameters do not change here."""


def start_server(port: int, listener: Any = None, context: Any = None) -> Any:
    """Return a server that listens on the loopback address, and only sends.

    Raises:
        BtMissionError: Where it cannot listen.
    """
    foxglove.set_log_level("CRITICAL")  # it would write a line for each thing a client does wrong
    try:
        return foxglove.start_server(
            name="bt-mission",
            host=LOOPBACK,
            port=port,
            capabilities=[Capability.Time],
            server_listener=listener,
            context=context or foxglove.Context(),
            message_backlog_size=BACKLOG,
        )
    except RuntimeError as error:
        is_taken = "in use" in str(error)
        why = "another program listens there" if is_taken else f"cannot listen there ({error})"
        raise BtMissionError(
            f"--foxglove-port {port}: {why}; --foxglove-port 0 takes any that is free"
        ) from None


class FoxgloveServer:
    """Serves every topic that somebody publishes; call :meth:`look` again and again.

    Args:
        node: Owns the subscriptions.
        port: To listen on; 0 takes any that is free.
        now_ns: Gives the time of the graph, ns, with which messages are marked.
        say: Told what cannot be served, a line at a time.

    Raises:
        BtMissionError: Where it cannot listen.
    """

    def __init__(
        self, node: Node, port: int, now_ns: Callable[[], int], say: Callable[[str], None]
    ) -> None:
        self.node = node
        self.is_broken = False
        """Has it failed, and been stopped?"""
        self._now_ns, self._say = now_ns, say
        self._context = foxglove.Context()
        self._newcomers = _Newcomers()
        self._server = start_server(port, self._newcomers, self._context)
        self._definitions = Definitions(share_folders())
        self._topics: dict[str, _ServedTopic | None] = {}
        """None stands for a topic that cannot be served."""
        self._settled: set[str] = set()
        """Topics with newcomers whom messages reach by the next time they are welcomed."""
        self._since_search, self._since_time = Stopwatch(), Stopwatch()
        self._since_welcome = Stopwatch()
        self._search()

    @property
    def link(self) -> str:
        """Where clients connect."""
        return f"ws://{LOOPBACK}:{self._server.port}"

    def look(self) -> None:
        """Pass on what has come. What fails here ends the server, and nothing else."""
        if self.is_broken:
            return
        try:
            self._look()
        except Exception as error:  # noqa: BLE001 - looking on must not change what happens
            self._say(f"the server for Foxglove failed: {described(error)}")
            self.close()

    def close(self) -> None:
        """Send clients away; the subscriptions go with the node."""
        if not self.is_broken:
            self.is_broken = True
            self._server.stop()

    def _look(self) -> None:
        if self._since_search.elapsed_s >= SEARCH_S:
            self._since_search = Stopwatch()
            self._search()
        if self._since_welcome.elapsed_s >= SETTLE_S:
            self._since_welcome = Stopwatch()
            for topic in self._settled:
                if (one := self._topics.get(topic)) is not None:
                    one.welcome()
            self._settled = self._newcomers.take()
        for one in self._topics.values():
            if one is not None:
                one.look()
        if self._since_time.elapsed_s >= TIME_S:
            self._since_time = Stopwatch()
            self._server.broadcast_time(self._now_ns())

    def _search(self) -> None:
        """Offer what has come up since the last time, and take back what has gone."""
        offers = {
            topic: (types, [one.qos_profile for one in found])
            for topic, types in self.node.get_topic_names_and_types()
            if topic not in NEVER and (found := self.node.get_publishers_info_by_topic(topic))
        }
        for topic in self._topics.keys() - offers.keys():
            if (gone := self._topics.pop(topic)) is not None:
                gone.close()
        for topic, (types, qos) in offers.items():
            if topic not in self._topics:
                try:
                    self._topics[topic] = self._serve(topic, types, qos)
                except BtMissionError as error:
                    self._topics[topic] = None
                    self._say(f"{topic} is not served: {error}")

    def _serve(self, topic: str, types: Sequence[str], offers: list[QoSProfile]) -> _ServedTopic:
        if len(types) > 1:
            raise BtMissionError(f"it has several types: {listed(sorted(types))}")
        message_class = topic_type(types[0])
        name, definition = with_plain_names(types[0], self._definitions.of(types[0]))
        schema = foxglove.Schema(name=name, encoding="ros2msg", data=definition.encode())
        channel = foxglove.Channel(
            topic, message_encoding="cdr", schema=schema, context=self._context
        )
        return _ServedTopic(self.node, channel, message_class, offers, self._now_ns)


class _Newcomers:
    """Hears from the server who has subscribed, on its thread: a deque takes that as it comes."""

    def __init__(self) -> None:
        self._topics: deque[str] = deque()

    def on_subscribe(self, _client: Any, channel: Any) -> None:
        """Note the topic."""
        self._topics.append(channel.topic)

    def on_unsubscribe(self, _client: Any, _channel: Any) -> None:
        """Leave it: the channel says whether somebody is left."""

    def take(self) -> set[str]:
        """Return the topics with somebody new since the last time."""
        return {self._topics.popleft() for _ in range(len(self._topics))}


class _ServedTopic:
    """A topic with its channel, and a subscription while there is a client."""

    def __init__(
        self,
        node: Node,
        channel: Any,
        message_class: Any,
        offers: list[QoSProfile],
        now_ns: Callable[[], int],
    ) -> None:
        self._node, self._channel, self._message_class = node, channel, message_class
        self._now_ns = now_ns
        self._qos = matching_qos(offers, DEPTH)
        self._subscription: Subscription | None = None

    def welcome(self) -> None:
        """Have a new client receive what is latched: a new subscription does, and all hear it."""
        if self._qos.durability is DurabilityPolicy.TRANSIENT_LOCAL:
            self._unsubscribe()

    def look(self) -> None:
        """Subscribe where a client does, and hand on what has come."""
        if not self._channel.has_sinks():
            self._unsubscribe()
            return
        if self._subscription is None:
            self._subscription = self._node.create_subscription(
                self._message_class,
                self._channel.topic(),
                self._send,  # where an executor serves the node
                self._qos,
                raw=True,
                event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
            )
        with (handle := self._subscription.handle):
            while (taken := handle.take_message(self._message_class, True)) is not None:
                self._send(taken[0])

    def close(self) -> None:
        """Offer it no longer."""
        self._unsubscribe()
        self._channel.close()

    def _unsubscribe(self) -> None:
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def _send(self, data: bytes) -> None:
        self._channel.log(data, log_time=self._now_ns())
