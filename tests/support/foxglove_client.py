"""A client of the WebSocket protocol of Foxglove that has nothing of the server's library."""

from __future__ import annotations

import json
import struct
from collections import defaultdict
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, Self

from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from bt_mission.core.wall_clock import Stopwatch

PROTOCOL = Subprotocol("foxglove.sdk.v1")
MESSAGE, TIME = 1, 2
PATIENCE_S = 60.0


class FoxgloveClient:
    """Subscribes to topics by their names, and keeps what comes, decoded.

    Args:
        link: Of the server.
    """

    def __init__(self, link: str) -> None:
        self.info: dict[str, Any] = {}
        self.channels: dict[str, dict[str, Any]] = {}
        """What the server offers, by topic."""
        self.heard: defaultdict[str, list[tuple[int, Any]]] = defaultdict(list)
        """Messages with their times, ns, by topic."""
        self.statuses: list[str] = []
        self.times: list[int] = []
        self._exit = ExitStack()
        self._socket = self._exit.enter_context(
            connect(link, subprotocols=[PROTOCOL], max_size=None)
        )
        self._subscribed: dict[int, str] = {}
        self._decoders: dict[str, Any] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._exit.close()

    def send(self, words: Any) -> None:
        """Send text, bytes, or an object as JSON."""
        is_raw = isinstance(words, str | bytes)
        self._socket.send(words if is_raw else json.dumps(words))

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
        while True:
            try:
                received = self._socket.recv(timeout=wait_s)
            except TimeoutError:
                return
            wait_s = 0.0
            if isinstance(received, str):
                self._take_words(json.loads(received))
            elif received[0] == MESSAGE:
                number, time_ns = struct.unpack("<IQ", received[1:13])
                topic = self._subscribed[number]
                self.heard[topic].append((time_ns, self._decoded(topic, received[13:])))
            elif received[0] == TIME:
                self.times.append(*struct.unpack("<Q", received[1:]))

    def _take_words(self, words: dict[str, Any]) -> None:
        match words["op"]:
            case "serverInfo":
                self.info = words
            case "advertise":
                self.channels |= {one["topic"]: one for one in words["channels"]}
            case "unadvertise":
                gone = set(words["channelIds"])
                for topic in [t for t, one in self.channels.items() if one["id"] in gone]:
                    del self.channels[topic]
            case "status":
                self.statuses.append(words["message"])

    def _decoded(self, topic: str, data: bytes) -> Any:
        if topic not in self._decoders:
            one = self.channels[topic]
            schema = Schema(
                id=1, name=one["schemaName"], encoding="ros2msg", data=one["schema"].encode()
            )
            self._decoders[topic] = DecoderFactory().decoder_for(one["encoding"], schema)
        return self._decoders[topic](data)
