"""Snapshots of a tree in the messages of py_trees_ros, for tools such as py-trees-tree-watcher.

A tool opens a stream by a service and gets a latched topic. Without a stream a tick costs nothing.
A stream without a subscriber is dropped after a while: its tool was killed.
"""

from __future__ import annotations

import statistics
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from diagnostic_msgs.msg import KeyValue
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import Decorator
from py_trees_ros_interfaces import msg, srv
from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from rclpy.publisher import Publisher
from unique_identifier_msgs.msg import UUID

from bt_mission.base.errors import BtMissionError
from bt_mission.base.ros_log import log_of
from bt_mission.base.stamps import NS
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.behaviours import control
from bt_mission.executive.behaviours.cleanup import Finally
from bt_mission.executive.behaviours.python_leaf import PythonLeaf
from bt_mission.executive.events.events import TreeRevised
from bt_mission.ros.event_messages import stamp
from bt_mission.ros.graph import LATCHED, REQUESTS
from bt_mission.ros.mission_details import as_json
from bt_mission.ros.mission_runtime import MissionRuntime

FOLDER = "~/snapshot_streams"
MOST_STREAMS = 10
SILENT_S = 10.0
SHORTEST_S = 0.02
"""Wall time between two snapshots: virtual time may run a hundred times as fast."""

NO_ID = UUID()
KIND = msg.Behaviour
_TYPES = (
    ((Sequence, Finally), KIND.SEQUENCE),
    ((Selector, control.Pick), KIND.SELECTOR),
    (Parallel, KIND.PARALLEL),
    (Decorator, KIND.DECORATOR),
    (Behaviour, KIND.BEHAVIOUR),
)


@dataclass
class _Stream:
    publisher: Publisher
    parameters: msg.SnapshotStreamParameters
    sent: object = None
    since_sent: Stopwatch = field(default_factory=Stopwatch)
    since_received: Stopwatch = field(default_factory=Stopwatch)


class SnapshotStreams:
    """Offers ``~/snapshot_streams/open``, ``close`` and ``reconfigure`` on a node."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._run: MissionRuntime | None = None
        self._streams: dict[str, _Stream] = {}
        self._count = 0
        self._nodes: dict[Behaviour, msg.Behaviour] = {}
        self._forget_ticks()
        answers = {"Open": self._open, "Close": self._close, "Reconfigure": self._reconfigure}
        self._services = [
            node.create_service(
                getattr(srv, f"{name}SnapshotStream"),
                f"{FOLDER}/{name.lower()}",
                answer,
                qos_profile=REQUESTS,
            )
            for name, answer in answers.items()
        ]

    def begin(self, run: MissionRuntime) -> None:
        """Show a run that starts, in the streams that are open, too."""
        self._publish_due(is_end=True)
        self._run, self._nodes = run, {}
        self._forget_ticks()
        run.executive.tick_wrappers.append(self._watch)
        run.executive.after_tick.append(self._after_tick)
        run.executive.events.subscribe(self._revise, TreeRevised)

    def _revise(self, _: TreeRevised) -> None:
        self._nodes = {}
        self._visited.clear()

    def close(self) -> None:
        """Publish the end, and destroy the streams and the services."""
        with suppress(InvalidHandle):  # its node was destroyed
            if self._node.context.ok():
                self._publish_due(is_end=True)
        for stream in self._streams.values():
            self._node.destroy_publisher(stream.publisher)
        self._streams.clear()
        while self._services:
            self._node.destroy_service(self._services.pop())

    def _open(self, request: Any, answer: Any) -> Any:
        name = request.topic_name or f"_snapshots_{self._count}"
        self._count += not request.topic_name
        path = name if name.startswith(("/", "~")) else f"{FOLDER}/{name}"
        try:
            answer.topic_name = self._set(self._node.resolve_topic_name(path), request.parameters)
        except (BtMissionError, RuntimeError) as error:  # rclpy's for an invalid name
            why = f"the stream of snapshots was not opened or changed: {error}"
            log_of(self._node).warning(why, throttle_duration_sec=1.0)
        return answer

    def _close(self, request: Any, answer: Any) -> Any:
        answer.result = request.topic_name in self._streams
        self._drop(request.topic_name)
        return answer

    def _reconfigure(self, request: Any, answer: Any) -> Any:
        if request.topic_name in self._streams:
            answer.result = bool(self._open(request, srv.OpenSnapshotStream.Response()).topic_name)
        return answer

    def _set(self, topic: str, parameters: msg.SnapshotStreamParameters) -> str:
        if not (period_s := parameters.snapshot_period) >= 0:  # such as NaN
            raise BtMissionError(
                f"snapshot_period: expected seconds from 0, or inf, got {period_s}", code="BT-916"
            )
        self._drop_unheard()
        if topic in self._streams:
            self._streams[topic].parameters = parameters
            return topic
        if len(self._streams) >= MOST_STREAMS:
            raise BtMissionError(f"{MOST_STREAMS} streams are open; close one first", code="BT-916")
        publisher = self._node.create_publisher(msg.BehaviourTree, topic, LATCHED)
        self._streams[topic] = _Stream(publisher, parameters)
        self._publish_due()
        return topic

    def _drop_unheard(self) -> None:
        for topic, stream in tuple(self._streams.items()):
            if stream.publisher.get_subscription_count():
                stream.since_received = Stopwatch()
            elif stream.since_received.elapsed_s > SILENT_S:
                self._drop(topic)

    def _drop(self, topic: str) -> None:
        if topic in self._streams:
            self._node.destroy_publisher(self._streams.pop(topic).publisher)
            if not self._streams:
                self._forget_ticks()

    def _forget_ticks(self) -> None:
        self._visited: set[Behaviour] = set()
        self._began_ns: int | None = None
        self._seconds: dict[str, deque[float]] = {
            name: deque(maxlen=10) for name in ("duration", "interval")
        }

    def _watch(self, walk: Iterator[Behaviour]) -> Iterator[Behaviour]:
        return self._watched(walk, self._run) if self._run and self._streams else walk

    def _watched(self, walk: Iterator[Behaviour], run: MissionRuntime) -> Iterator[Behaviour]:
        interval_s = 0.0 if self._began_ns is None else (run.now_ns - self._began_ns) / NS
        self._seconds["interval"].append(interval_s)
        self._began_ns, wall = run.now_ns, Stopwatch()
        self._visited = visited = set()
        for node in walk:
            visited.add(node)
            yield node
        self._seconds["duration"].append(wall.elapsed_s)

    def _after_tick(self) -> None:
        self._drop_unheard()
        self._publish_due(is_end=self._run is not None and self._run.executive.is_done)

    def _publish_due(self, *, is_end: bool = False) -> None:
        """Publish to the streams for which something has changed, or whose period has passed."""
        if self._run is None or not self._streams:
            return
        state = self._run.executive.mission_state
        statuses = (self._run.executive.run, state.statuses[:], state.since_ns[:])
        for stream in self._streams.values():
            since_s, is_new = stream.since_sent.elapsed_s, stream.sent != statuses
            period_s = 0.98 * stream.parameters.snapshot_period  # ticks have a rate of their own
            is_due = since_s >= SHORTEST_S and (is_new or since_s >= period_s)
            if is_due or stream.sent is None or (is_end and is_new):
                tree = self._tree(self._run, with_variables=stream.parameters.blackboard_data)
                tree.changed, stream.sent, stream.since_sent = is_new, statuses, Stopwatch()
                stream.publisher.publish(tree)

    def _tree(self, run: MissionRuntime, *, with_variables: bool) -> msg.BehaviourTree:
        executive = run.executive
        # As py_trees_ros: children before their parents.
        self._nodes = self._nodes or {
            behaviour: _described(behaviour) for behaviour in executive.root.iterate()
        }
        ids: dict[Behaviour | None, UUID] = {
            node: message.own_id for node, message in self._nodes.items()
        }
        # Which nodes were visited before the first stream is unknown: take those with a status.
        visited = self._visited or {x for x in self._nodes if x.status is not Status.INVALID}
        for node, message in self._nodes.items():
            tip = node.tip()
            message.status = getattr(KIND, node.status.name)
            message.message = str(node.feedback_message)
            message.tip_id = NO_ID if tip is node else ids.get(tip, NO_ID)
            message.current_child_id = ids.get(getattr(_inner(node), "current_child", None), NO_ID)
            message.is_active = node in visited
        values = run.variables() if with_variables else {}
        ticks = msg.Statistics(count=executive.ticks, stamp=stamp(self._began_ns or run.now_ns))
        for name, series in self._seconds.items():
            if series:
                setattr(ticks, f"tick_{name}", series[-1])
                setattr(ticks, f"tick_{name}_average", statistics.fmean(series))
            if len(series) > 1:
                setattr(ticks, f"tick_{name}_variance", statistics.variance(series))
        return msg.BehaviourTree(
            behaviours=[*self._nodes.values()],
            blackboard_on_visited_path=[
                KeyValue(key=name, value=as_json(value)) for name, value in values.items()
            ],
            statistics=ticks,
        )


def _described(node: Behaviour) -> msg.Behaviour:
    """Return everything about a node that never changes."""
    inner = _inner(node)
    detail = "WithMemory" if isinstance(inner, Sequence | Selector) and inner.memory else ""
    return KIND(
        name=node.name,
        class_name=f"{type(inner).__module__}.{type(inner).__name__}",
        own_id=_id_of(node),
        parent_id=_id_of(node.parent) if node.parent else NO_ID,
        child_ids=[_id_of(child) for child in node.children],
        type=next(value for classes, value in _TYPES if isinstance(inner, classes)),
        additional_detail=inner.policy_name if isinstance(inner, control.Parallel) else detail,
        blackbox_level=getattr(KIND, f"BLACKBOX_LEVEL_{inner.blackbox_level.name}"),
        blackboard_access=[
            msg.KeyValue(key=key, value=access)
            for client in inner.blackboards
            for keys, access in ((client.read, "r"), (client.write, "w"), (client.exclusive, "x"))
            for key in sorted(keys)
        ],
    )


def _inner(node: Behaviour) -> Behaviour:
    """Return a user's behaviour in place of the node around it."""
    return node.behaviour if isinstance(node, PythonLeaf) else node


def _id_of(node: Behaviour) -> UUID:
    return UUID(uuid=list(node.id.bytes))
