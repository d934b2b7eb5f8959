"""A client of the WebSocket protocol of Foxglove that shares nothing with the server.

It never waits unless it is asked to: in a test it takes turns with the server, on one thread.
"""

from __future__ import annotations

import json
import select
import socket
import struct
from collections import defaultdict
from collections.abc import Callable
from typing import Any, Self

from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from websockets.client import ClientProtocol
from websockets.frames import Frame, Opcode
from websockets.typing import Subprotocol
from websockets.uri import parse_uri

from bt_mission.base.wall_clock import Stopwatch
from tests.support.processes import PATIENCE_S

PROTOCOL = Subprotocol("foxglove.sdk.v1")
MESSAGE, TIME = 1, 2


class FoxgloveClient:
    """Subscribes to topics by their names, and keeps what comes, decoded.

    Args:
        link: Of the server.
    """

    def __init__(self, link: str) -> None:
        self.info: dict[str, Any] = {}
        self.channels: dict[str, dict[str, Any]] = {}
        """What the server offers, by topic."""
        self.received: defaultdict[str, list[tuple[int, Any]]] = defaultdict(list)
        """Messages with their times, ns, by topic."""
        self.statuses: list[str] = []
        self.times: list[int] = []
        self.close_code: int | None = None
        uri = parse_uri(link)
        self._protocol = ClientProtocol(uri, subprotocols=[PROTOCOL], max_size=None)
        self._socket = socket.create_connection((uri.host, uri.port))
        self._protocol.send_request(self._protocol.connect())
        self._flush()
        self._subscribed: dict[int, str] = {}
        self._decoders: dict[str, Any] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def send(self, words: Any) -> None:
        """Send text, bytes, or an object as JSON, once the server has answered."""
        if isinstance(words, bytes):
            self._protocol.send_binary(words)
        else:
            text = words if isinstance(words, str) else json.dumps(words)
            self._protocol.send_text(text.encode())
        self._flush()

    def _flush(self) -> None:
        self._socket.sendall(b"".join(self._protocol.data_to_send()))

    def subscribe(self, *topics: str) -> None:
        """Subscribe to topics that are offered."""
        wanted = []
        for topic in topics:
            number = len(self._subscribed) + 1
            self._subscribed[number] = topic
            wanted.append({"id": number, "channelId": self.channels[topic]["id"]})
        self.send({"op": "subscribe", "subscriptions": wanted})

    def wait_for(self, is_true: Callable[[], object]) -> None:
        """Take what comes until something holds."""
        since = Stopwatch()
        while not is_true():
            assert since.elapsed_s < PATIENCE_S
            self.take(wait_s=1.0)

    def take(self, wait_s: float = 0.0) -> None:
        """Take what has come, and wait for the first of it."""
        while self.close_code is None and select.select([self._socket], [], [], wait_s)[0]:
            wait_s = 0.0
            data = self._socket.recv(1 << 16)
            if data:
                self._protocol.receive_data(data)
            else:
                self._protocol.receive_eof()
                self.close_code = self._protocol.close_code
            self._flush()
            for event in self._protocol.events_received():
                if not isinstance(event, Frame):
                    assert self._protocol.handshake_exc is None
                elif event.opcode is Opcode.TEXT:
                    self._take_words(json.loads(bytes(event.data)))
                elif event.opcode is Opcode.BINARY:
                    self._take_data(bytes(event.data))

    def _take_data(self, received: bytes) -> None:
        if received[0] == MESSAGE:
            number, time_ns = struct.unpack("<IQ", received[1:13])
            topic = self._subscribed[number]
            self.received[topic].append((time_ns, self._decoded(topic, received[13:])))
        elif received[0] == TIME:
            self.times.append(*struct.unpack("<Q", received[1:]))

    def _take_words(self, words: dict[str, Any]) -> None:
        match words["op"]:
            case "serverInfo":
                self.info = words
            case "advertise":
                self.channels |= {channel["topic"]: channel for channel in words["channels"]}
            case "unadvertise":
                gone = set(words["channelIds"])
                for topic in [t for t, channel in self.channels.items() if channel["id"] in gone]:
                    del self.channels[topic]
            case "status":
                self.statuses.append(words["message"])

    def _decoded(self, topic: str, data: bytes) -> Any:
        if topic not in self._decoders:
            channel = self.channels[topic]
            schema = Schema(
                id=1,
                name=channel["schemaName"],
                encoding="ros2msg",
                data=channel["schema"].encode(),
            )
            self._decoders[topic] = DecoderFactory().decoder_for(channel["encoding"], schema)
        return self._decoders[topic](data)
