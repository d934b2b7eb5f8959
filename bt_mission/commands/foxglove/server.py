"""Serves topics over the WebSocket protocol of Foxglove.

A topic costs nothing until a client subscribes to it: only then there is a subscription in ROS, and
its messages are passed on serialized, as they arrive. Messages for a slow client are dropped.
"""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSProfile
from starlette.applications import Starlette
from starlette.routing import WebSocketRoute

from bt_mission.base.dds.publishers import CLOCK
from bt_mission.base.diagnostics import listed
from bt_mission.base.errors import BtMissionError, described
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.cdr.definitions import definition_of, with_plain_names
from bt_mission.commands.foxglove.clients import Clients, FoxgloveChannel
from bt_mission.ros.interface_types import topic_type
from bt_mission.ros.subscriber import matching_qos
from bt_mission.sessions.session import Onlooker
from bt_mission.views.web.guarded_server import (
    Connections,
    FrameRate,
    GuardedServer,
    listening_socket,
)

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.subscription import Subscription

LOOPBACK, PORT = "127.0.0.1", 8765

SEARCH_S = 1.0
"""Wall time between two looks at what topics there are."""

TIME_S = 0.05
"""Wall time between two messages with the time of the graph."""

TURN_S = 0.005
"""Wall time between two turns of the event loop, if none runs in this process."""

TURNS = 12
"""Passes of the event loop in a turn: the number between a request and its response."""

CLOSE_S = 2.0
"""Wall time within which clients are disconnected."""

FRAMES = FrameRate(long_run_s=200.0, most=2000)
"""The rate of messages of a client: the application subscribes to each topic of a layout
separately.
"""

MOST_BYTES = 1 << 18
"""Of a message of a client."""

DEPTH = 100
"""Messages of a topic that may wait until they are taken."""

NEVER = (CLOCK, "/parameter_events")
"""Topics that are not offered: the protocol has the time, and parameters do not change here."""


def listen(port: int) -> socket.socket:
    """Return a socket that listens on the loopback address.

    Raises:
        BtMissionError: Where it cannot listen.
    """
    return listening_socket(LOOPBACK, port, "--foxglove-port")


class FoxgloveServer(Onlooker):
    """Serves every topic that somebody publishes; call :meth:`after_step` again and again.

    Args:
        node: Owns the subscriptions.
        port: To listen on; 0 takes any that is free.
        now_ns: Gives the time of the graph, ns, with which messages are marked.
        say: Called with a line for each topic that cannot be served.

    Raises:
        BtMissionError: Where it cannot listen.
    """

    def __init__(
        self, node: Node, port: int, now_ns: Callable[[], int], say: Callable[[str], None]
    ) -> None:
        self.node: Node = node
        self.is_broken = False
        """Whether it has failed, and was stopped."""
        self._now_ns, self._say = now_ns, say
        self._listener = listen(port)
        self._port: int = self._listener.getsockname()[1]
        connections = Connections()
        self._newcomers: set[int] = set()
        self._clients = Clients(connections, lambda client: self._newcomers.add(client.number))
        app = Starlette(routes=[WebSocketRoute("/{path:path}", self._clients.open)])
        self._server = GuardedServer(app, connections, FRAMES, most_bytes=MOST_BYTES)
        self._turning: _Turning | None = None
        self._topics: dict[str, _ServedTopic | None] = {}
        """None is a topic that cannot be served."""
        self._since_search, self._since_time = Stopwatch(), Stopwatch()
        self._search()

    @property
    def link(self) -> str:
        """The address for clients."""
        return f"ws://{LOOPBACK}:{self._port}"

    def after_step(self) -> None:
        """Pass on received messages. An error here ends only the server."""
        if self.is_broken:
            return
        try:
            self._look()
        except Exception as error:  # noqa: BLE001 - looking on must not change what happens
            self._say(f"the server for Foxglove failed: {described(error)}")
            self.close()

    def close(self) -> None:
        """Disconnect the clients; the subscriptions end with the node."""
        if not self.is_broken:
            self.is_broken = True
            if self._turning is None:
                self._listener.close()
            else:
                self._turning.close()

    def _look(self) -> None:
        if self._since_search.elapsed_s >= SEARCH_S:
            self._since_search = Stopwatch()
            self._search()
        newcomers, self._newcomers = self._newcomers, set()
        for topic in self._topics.values():
            if topic is not None:
                topic.look(has_newcomers=topic.channel.number in newcomers)
        if self._since_time.elapsed_s >= TIME_S:
            self._since_time = Stopwatch()
            self._clients.send_time(self._now_ns())
        if self._turning is None:
            self._turning = _Turning(self._server, self._listener)
        self._turning.look()

    def _search(self) -> None:
        """Offer new topics, and withdraw those that are gone."""
        offers = {
            topic: (types, [publisher.qos_profile for publisher in publishers])
            for topic, types in self.node.get_topic_names_and_types()
            if topic not in NEVER and (publishers := self.node.get_publishers_info_by_topic(topic))
        }
        for topic in self._topics.keys() - offers.keys():
            if (gone := self._topics.pop(topic)) is not None:
                gone.close()
                self._clients.withdraw(gone.channel)
        for topic, (types, qos) in offers.items():
            if topic not in self._topics:
                try:
                    self._topics[topic] = self._serve(topic, types, qos)
                except BtMissionError as error:
                    self._topics[topic] = None
                    self._say(f"{topic} is not served: {error}")

    def _serve(self, topic: str, types: Sequence[str], offers: list[QoSProfile]) -> _ServedTopic:
        if len(types) > 1:
            raise BtMissionError(f"it has several types: {listed(sorted(types))}", code="BT-912")
        message_class = topic_type(types[0])
        name, definition = with_plain_names(types[0], definition_of(types[0]))
        words = {
            "topic": topic,
            "encoding": "cdr",
            "schemaName": name,
            "schema": definition,
            "schemaEncoding": "ros2msg",
        }
        channel = self._clients.offer(words)
        return _ServedTopic(self.node, channel, message_class, offers, self._now_ns)


class _Turning:
    """Serves on the running event loop; without one, on one that is turned in between."""

    def __init__(self, server: GuardedServer, listener: socket.socket) -> None:
        self._server, self._listener = server, listener
        self._own: asyncio.Runner | None = None
        try:
            self._loop = asyncio.get_running_loop()
        except RuntimeError:
            self._own = asyncio.Runner(loop_factory=asyncio.new_event_loop)
            self._loop = self._own.get_loop()
        self._serving = self._loop.create_task(server.serve([listener]))
        self._since = Stopwatch()

    def look(self) -> None:
        """Do what is due.

        Raises:
            Exception: The error of the server.
        """
        if self._own is not None and self._since.elapsed_s >= TURN_S:
            self._since = Stopwatch()
            for _ in range(TURNS):
                self._loop.call_soon(self._loop.stop)
                self._loop.run_forever()
        if self._serving.done():
            self._serving.result()

    def close(self) -> None:
        """Disconnect the clients: at once, or on a running loop with its next turns."""
        self._server.should_exit = True
        if self._own is not None:
            self._loop.run_until_complete(asyncio.wait([self._serving], timeout=CLOSE_S))
            self._own.close()
        if self._loop.is_closed():
            self._listener.close()


class _ServedTopic:
    """A topic with its channel, and a subscription while there is a client."""

    def __init__(
        self,
        node: Node,
        channel: FoxgloveChannel,
        message_class: Any,
        offers: list[QoSProfile],
        now_ns: Callable[[], int],
    ) -> None:
        self._node, self.channel, self._message_class = node, channel, message_class
        self._now_ns = now_ns
        self._qos = matching_qos(offers, DEPTH)
        self._subscription: Subscription | None = None

    def look(self, *, has_newcomers: bool) -> None:
        """Subscribe if a client does, and pass on received messages.

        A new subscription receives latched messages, so a new client causes one.
        """
        if has_newcomers and self._qos.durability is DurabilityPolicy.TRANSIENT_LOCAL:
            self._unsubscribe()
        if not self.channel.viewers:
            self._unsubscribe()
            return
        if self._subscription is None:
            self._subscription = self._node.create_subscription(
                self._message_class,
                self.channel.words["topic"],
                self._send,  # where an executor serves the node
                self._qos,
                raw=True,
                event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
            )
        with (handle := self._subscription.handle):
            while (taken := handle.take_message(self._message_class, True)) is not None:
                self._send(taken[0])

    def close(self) -> None:
        """Leave the topic."""
        self._unsubscribe()

    def _unsubscribe(self) -> None:
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def _send(self, data: bytes) -> None:
        self.channel.send(data, self._now_ns())
