"""The clients of the server, and the WebSocket protocol of Foxglove (`foxglove.sdk.v1`).

This is the part of the protocol that a sending server needs. It offers channels; clients subscribe
to them, and receive their messages and the time.
"""

from __future__ import annotations

import asyncio
import json
import secrets
import struct
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from bt_mission.base.errors import described
from bt_mission.views.web.guarded_server import Connections

PROTOCOL = "foxglove.sdk.v1"

BACKLOG = 256
"""Messages that may wait for a client; the oldest are dropped for a slower one."""

BACKLOG_BYTES = 4 << 20
"""Bytes of these messages, but for the newest."""

MESSAGE, TIME = 1, 2
"""Kinds of binary messages."""

ERROR = 2
"""The level of a status."""

FAILED = 1011

LONGEST_WORD = 100
"""Characters of a client's text that a response repeats."""


@dataclass(eq=False)
class FoxgloveChannel:
    """A topic that is offered.

    Attributes:
        words: Its description for clients.
        viewers: The subscribed clients, with the numbers of their subscriptions.
    """

    number: int
    words: dict[str, Any]
    viewers: dict[Client, int] = field(default_factory=dict)

    def send(self, data: bytes, time_ns: int) -> None:
        """Send a message to all subscribed clients."""
        for client, subscription in self.viewers.items():
            client.put(struct.pack("<BIQ", MESSAGE, subscription, time_ns) + data)


class Client:
    """A connected client: its channels, and its waiting messages.

    Args:
        socket: Accepted already.
        channels: The offered channels, by number.
        on_subscribe: Called with each channel to which it subscribes.
    """

    def __init__(
        self,
        socket: WebSocket,
        channels: dict[int, FoxgloveChannel],
        on_subscribe: Callable[[FoxgloveChannel], None],
    ) -> None:
        self.time_ns = 0
        """The newest time of the graph."""
        self.waiting_bytes = 0
        """Of the messages that wait for it."""
        self._socket, self._channels, self._on_subscribe = socket, channels, on_subscribe
        self._known: dict[int, FoxgloveChannel] = {}
        self._subscribed: dict[int, FoxgloveChannel] = {}
        self._waiting: deque[bytes] = deque()
        self._errors: deque[str] = deque(maxlen=BACKLOG)
        self._has_messages = asyncio.Event()

    def put(self, message: bytes) -> None:
        """Send it when the client takes it."""
        self._waiting.append(message)
        self.waiting_bytes += len(message)
        while len(self._waiting) > 1 and (
            len(self._waiting) > BACKLOG or self.waiting_bytes > BACKLOG_BYTES
        ):
            self._next()
        self._has_messages.set()

    def _next(self) -> bytes:
        message = self._waiting.popleft()
        self.waiting_bytes -= len(message)
        return message

    def wake(self) -> None:
        """Send what has changed: the channels, the time."""
        self._has_messages.set()

    async def serve(self) -> None:
        """Send and receive until the client has left."""
        both = (asyncio.create_task(self._send_all()), asyncio.create_task(self._listen()))
        await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
        for task in both:
            task.cancel()
        for channel in self._known.values():
            channel.viewers.pop(self, None)
        for fault in await asyncio.gather(*both, return_exceptions=True):
            if not isinstance(fault, Exception) or isinstance(fault, WebSocketDisconnect):
                continue
            if self._socket.application_state is WebSocketState.CONNECTED:
                await self._socket.close(FAILED, described(fault)[:LONGEST_WORD])

    async def _send_all(self) -> None:
        await self._say(
            op="serverInfo",
            name="bt-mission",
            capabilities=["time"],
            supportedEncodings=[],
            metadata={},
            sessionId=secrets.token_hex(8),
        )
        sent_ns = 0
        self._has_messages.set()
        while True:
            await self._has_messages.wait()
            self._has_messages.clear()
            await self._offer()
            while self._errors:
                await self._say(op="status", level=ERROR, message=self._errors.popleft())
            while self._waiting:
                await self._socket.send_bytes(self._next())
            if self.time_ns != sent_ns:
                sent_ns = self.time_ns
                await self._socket.send_bytes(struct.pack("<BQ", TIME, sent_ns))

    async def _offer(self) -> None:
        gone = [number for number in self._known if number not in self._channels]
        new = [self._channels[number] for number in self._channels.keys() - self._known.keys()]
        if gone:
            for number in gone:
                del self._known[number]
            await self._say(op="unadvertise", channelIds=gone)
        if new:
            self._known |= {channel.number: channel for channel in new}
            words = [{"id": channel.number, **channel.words} for channel in new]
            await self._say(op="advertise", channels=words)

    async def _say(self, **words: Any) -> None:
        await self._socket.send_text(json.dumps(words))

    async def _listen(self) -> None:
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            if why := self._refusal(message.get("text")):
                self._errors.append(why)
                self._has_messages.set()

    def _refusal(self, text: str | None) -> str:
        """Handle a request of a client. Return the refusal, or an empty text."""
        if text is None:
            return "this server takes no binary messages"
        try:
            words = json.loads(text)
        except (ValueError, RecursionError):
            return "the message is not JSON"
        match words:
            case {"op": "subscribe", "subscriptions": [*wanted]}:
                faults = [why for number in wanted if (why := self._subscribe(number))]
            case {"op": "unsubscribe", "subscriptionIds": [*numbers]}:
                faults = [why for number in numbers if (why := self._unsubscribe(number))]
            case {"op": str(operation)}:
                return f"this server does not support {operation[:LONGEST_WORD]!r}"
            case _:
                return "the message is not a request: expected an object with 'op'"
        return faults[0] if faults else ""

    def _subscribe(self, wanted: Any) -> str:
        match wanted:
            case {"id": int(subscription), "channelId": int(number)} if 0 <= subscription < 1 << 32:
                channel = self._channels.get(number)
            case _:
                return "expected a subscription with numbers as 'id' and 'channelId'"
        if channel is None:
            return f"unknown channel {str(number)[:LONGEST_WORD]}"
        if self in channel.viewers or subscription in self._subscribed:
            return f"channel {number} or subscription {subscription} is already in use"
        channel.viewers[self] = subscription
        self._subscribed[subscription] = channel
        self._on_subscribe(channel)
        return ""

    def _unsubscribe(self, subscription: Any) -> str:
        if not isinstance(subscription, int) or subscription not in self._subscribed:
            return "unknown subscription"
        self._subscribed.pop(subscription).viewers.pop(self, None)
        return ""


class Clients:
    """The connected clients.

    Args:
        connections: Their connections.
        on_subscribe: Called with each channel to which a client subscribes.
    """

    def __init__(
        self, connections: Connections, on_subscribe: Callable[[FoxgloveChannel], None]
    ) -> None:
        self.channels: dict[int, FoxgloveChannel] = {}
        """The offered channels, by number."""
        self._connections, self._on_subscribe = connections, on_subscribe
        self._clients: set[Client] = set()
        self._last_number = 0

    def offer(self, words: dict[str, Any]) -> FoxgloveChannel:
        """Offer a channel."""
        self._last_number += 1
        channel = self.channels[self._last_number] = FoxgloveChannel(self._last_number, words)
        self._wake()
        return channel

    def withdraw(self, channel: FoxgloveChannel) -> None:
        """Offer it no longer."""
        del self.channels[channel.number]
        channel.viewers.clear()
        self._wake()

    def send_time(self, time_ns: int) -> None:
        """Send each the time of the graph, ns."""
        for client in self._clients:
            client.time_ns = time_ns
        self._wake()

    async def open(self, socket: WebSocket) -> None:
        """Serve a client until it leaves."""
        if PROTOCOL not in socket.scope["subprotocols"]:
            await socket.close()
            return
        with self._connections.admitted(socket.scope):
            await socket.accept(PROTOCOL)
            client = Client(socket, self.channels, self._on_subscribe)
            self._clients.add(client)
            try:
                await client.serve()
            finally:
                self._clients.discard(client)

    def _wake(self) -> None:
        for client in self._clients:
            client.wake()
