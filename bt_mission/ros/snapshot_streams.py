"""Streams of snapshots for the tools of py_trees_ros, such as ``py-trees-tree-watcher``.

A tool opens a stream by a service, and gets a topic of its own. Nothing is done for a tick while
no stream is open. One that nobody listens to is dropped after a while: its tool was killed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from diagnostic_msgs.msg import KeyValue
from rclpy.exceptions import InvalidHandle, NameValidationException
from rclpy.expand_topic_name import expand_topic_name
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.validate_full_topic_name import validate_full_topic_name

from bt_mission.core.errors import BtMissionError
from bt_mission.core.ros_log import log_of
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.language.message_types import UnknownType
from bt_mission.ros.graph import LATCHED, REQUESTS
from bt_mission.ros.interface_types import check_type, message_type, service_type
from bt_mission.ros.mission_details import MissionRun
from bt_mission.ros.snapshot_messages import PACKAGE, TREE_TYPE, TreeSnapshots

FOLDER = "snapshot_streams"
"""Below the name of a node: its services for streams, and the topics of streams."""

MOST_STREAMS = 10
LONGEST_NAME = 200
"""Characters of a topic."""

UNHEARD_S = 10.0
"""Wall time after which a stream is dropped that nobody listens to."""

SHORTEST_S = 0.02
"""Wall time between two snapshots: virtual time may run a hundred times as fast."""

CLOSE_ENOUGH = 0.98
"""Of a period that has passed: ticks come at a rate of their own."""


@dataclass
class _Stream:
    publisher: Publisher
    parameters: Any
    has_news: bool = True
    """Has a status changed that it was not told of?"""
    since_told: Stopwatch = field(default_factory=Stopwatch)
    since_heard: Stopwatch = field(default_factory=Stopwatch)


class SnapshotStreams:
    """Offers ``~/snapshot_streams/open``, ``close`` and ``reconfigure``.

    Where `py_trees_ros_interfaces` is not installed, it offers nothing.

    Args:
        node: Owns the services; their names begin with its own.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._run: MissionRun | None = None
        self._snapshots: TreeSnapshots | None = None
        self._streams: dict[str, _Stream] = {}
        self._count = 0
        self._services: list[Any] = []
        try:
            self._type = message_type(TREE_TYPE)
            kinds = {
                name: service_type(f"{PACKAGE}/srv/{name.capitalize()}SnapshotStream")
                for name in ("open", "close", "reconfigure")
            }
        except UnknownType:
            return
        serve: dict[str, Callable[[Any, Any], Any]] = {
            "open": self._open,
            "close": self._close,
            "reconfigure": self._reconfigure,
        }
        for name, kind in kinds.items():
            service = node.create_service(
                kind, f"~/{FOLDER}/{name}", serve[name], qos_profile=REQUESTS
            )
            self._services.append(service)

    def begin(self, run: MissionRun) -> None:
        """Show a mission that starts, in the streams that are open, too."""
        self._leave()
        self._run = run
        if self._streams:
            self._follow(run)

    def close(self) -> None:
        """Tell the end, and destroy the streams and the services."""
        self._leave()
        for topic in tuple(self._streams):
            self._drop(topic)
        while self._services:
            self._node.destroy_service(self._services.pop())

    # ---- the services --------------------------------------------------------------------

    def _open(self, request: Any, answer: Any) -> Any:
        try:
            answer.topic_name = self._opened(request.topic_name, request.parameters)
        except BtMissionError as error:
            self._refuse("no stream of snapshots was opened", error)
        return answer

    def _close(self, request: Any, answer: Any) -> Any:
        answer.result = request.topic_name in self._streams
        if answer.result:
            self._drop(request.topic_name)
        return answer

    def _reconfigure(self, request: Any, answer: Any) -> Any:
        stream = self._streams.get(request.topic_name)
        try:
            if stream is not None:
                stream.parameters = _checked(request.parameters)
                answer.result = True
        except BtMissionError as error:
            self._refuse(f"the stream {request.topic_name} stays as it is", error)
        return answer

    def _refuse(self, what: str, error: BtMissionError) -> None:
        """Say why; the answers of these services have no room for it."""
        log_of(self._node).warning(f"{what}: {error}", throttle_duration_sec=1.0)

    # ---- streams -------------------------------------------------------------------------

    def _opened(self, wanted: str, parameters: Any) -> str:
        topic = self._topic(wanted)
        parameters = _checked(parameters)
        if (known := self._streams.get(topic)) is not None:
            known.parameters = parameters
            return topic
        self._drop_unheard()
        if len(self._streams) >= MOST_STREAMS:
            raise BtMissionError(f"{MOST_STREAMS} streams are open; close one first")
        types = dict(self._node.get_topic_names_and_types()).get(topic, ())
        check_type(topic, TREE_TYPE, types)
        publisher = self._node.create_publisher(self._type, topic, LATCHED)
        self._streams[topic] = stream = _Stream(publisher, parameters)
        if self._run is not None:
            self._publish(stream, self._snapshots or self._follow(self._run))
        return topic

    def _topic(self, wanted: str) -> str:
        if not wanted:
            wanted, self._count = f"_snapshots_{self._count}", self._count + 1
        if len(wanted) > LONGEST_NAME:
            raise BtMissionError(f"expected a topic of at most {LONGEST_NAME} characters")
        name = wanted if wanted.startswith(("/", "~")) else f"~/{FOLDER}/{wanted}"
        node = self._node
        try:
            topic: str = expand_topic_name(name, node.get_name(), node.get_namespace())
            validate_full_topic_name(topic)
        except (NameValidationException, ValueError) as error:
            first, *_ = str(error).splitlines()
            raise BtMissionError(
                f"expected the name of a topic, got {wanted!r}: {first}"
            ) from error
        return topic

    def _drop_unheard(self) -> None:
        for topic, stream in tuple(self._streams.items()):
            if stream.publisher.get_subscription_count():
                stream.since_heard = Stopwatch()
            elif stream.since_heard.elapsed_s > UNHEARD_S:
                self._drop(topic)

    def _drop(self, topic: str) -> None:
        self._node.destroy_publisher(self._streams.pop(topic).publisher)
        if not self._streams:
            self._leave()

    # ---- the mission ---------------------------------------------------------------------

    def _follow(self, run: MissionRun) -> TreeSnapshots:
        self._snapshots = TreeSnapshots(run)
        run.executive.after_tick.append(self._after_tick)
        return self._snapshots

    def _leave(self) -> None:
        """Tell what is left to tell, and follow the mission no longer."""
        if self._snapshots is None or self._run is None:
            return
        with suppress(InvalidHandle):  # its node was destroyed, and the streams with it
            if self._node.context.ok():
                self._publish_due(self._snapshots, at_once=True)
        self._snapshots.close()
        self._run.executive.after_tick.remove(self._after_tick)
        self._snapshots = None

    def _after_tick(self) -> None:
        self._drop_unheard()
        if self._snapshots is not None and self._run is not None:
            self._snapshots.end_tick()
            self._publish_due(self._snapshots, at_once=self._run.executive.is_done)

    def _publish_due(self, snapshots: TreeSnapshots, *, at_once: bool) -> None:
        has_changed = snapshots.has_changed
        snapshots.forget_changes()
        for stream in self._streams.values():
            stream.has_news |= has_changed
            since_s = stream.since_told.elapsed_s
            is_late = since_s >= CLOSE_ENOUGH * stream.parameters.snapshot_period and not at_once
            if (stream.has_news or is_late) and (at_once or since_s >= SHORTEST_S):
                self._publish(stream, snapshots)

    def _publish(self, stream: _Stream, snapshots: TreeSnapshots) -> None:
        message = snapshots.describe()
        message.changed = stream.has_news
        if stream.parameters.blackboard_data:
            message.blackboard_on_visited_path = [
                KeyValue(key=key, value=value) for key, value in snapshots.variables().items()
            ]
        stream.publisher.publish(message)
        stream.has_news, stream.since_told = False, Stopwatch()


def _checked(parameters: Any) -> Any:
    """Return the parameters of a stream. Raises BtMissionError for nonsense."""
    period_s = parameters.snapshot_period
    if math.isnan(period_s) or period_s < 0:
        raise BtMissionError(f"snapshot_period: expected seconds from 0, or inf, got {period_s}")
    return parameters
