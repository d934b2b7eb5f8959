"""A client of snapshot streams that does as the tree watcher of py_trees_ros does."""

from __future__ import annotations

import math
from typing import Any
from uuid import UUID

from py_trees_ros_interfaces.msg import Behaviour, BehaviourTree, SnapshotStreamParameters
from py_trees_ros_interfaces.srv import CloseSnapshotStream, OpenSnapshotStream
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

LATCHED = QoSProfile(
    depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.RELIABLE
)
SIGNS = {
    Behaviour.INVALID: "-",
    Behaviour.RUNNING: "*",
    Behaviour.SUCCESS: "o",
    Behaviour.FAILURE: "x",
}
TYPES = {
    Behaviour.BEHAVIOUR: "-->",
    Behaviour.SEQUENCE: "{-}",
    Behaviour.SELECTOR: "{o}",
    Behaviour.PARALLEL: "/_/",
    Behaviour.DECORATOR: "-^-",
}
"""It knows no others, and stops with a traceback where it meets one."""


def parameters(period_s: float = math.inf, **what: bool) -> SnapshotStreamParameters:
    """Of a stream; that of the watcher tells of changes only."""
    return SnapshotStreamParameters(snapshot_period=period_s, **what)


class TreeWatcher:
    """Finds the one tree of a graph by the types of its services, and opens a stream.

    Args:
        ros: The graph.
    """

    def __init__(self, ros: Any, period_s: float = math.inf, topic: str = "", **what: bool) -> None:
        self._ros = ros
        self.snapshots: list[BehaviourTree] = []
        self.opener = self._service("py_trees_ros_interfaces/srv/OpenSnapshotStream")
        self.closer = self._service("py_trees_ros_interfaces/srv/CloseSnapshotStream")
        asked = {"topic_name": topic, "parameters": parameters(period_s, **what)}
        self.topic: str = ros.call(OpenSnapshotStream, self.opener, **asked).topic_name
        assert ros.client.count_publishers(self.topic) == 1
        self._subscription = ros.client.create_subscription(
            BehaviourTree, self.topic, self.snapshots.append, LATCHED
        )

    def _service(self, type_name: str) -> str:
        known = self._ros.client.get_service_names_and_types()
        (name,) = (name for name, types in known if type_name in types)
        found_name: str = name
        return found_name

    def wait_for(self, count: int) -> None:
        """Let time pass until so many snapshots are here."""
        self._ros.spin_until(lambda: len(self.snapshots) >= count)

    def leave(self) -> None:
        """Be killed: without a word to the tree."""
        self._ros.client.destroy_subscription(self._subscription)

    def close(self) -> bool:
        """End the stream as it should be; gives whether there was one."""
        answer = self._ros.call(CloseSnapshotStream, self.closer, topic_name=self.topic)
        return bool(answer.result)

    @property
    def newest(self) -> BehaviourTree:
        """The newest snapshot, once there is one."""
        self.wait_for(1)
        return self.snapshots[-1]

    def drawn(self, snapshot: BehaviourTree | None = None) -> list[str]:
        """A snapshot as the watcher draws it: statuses of the nodes that the tick visited."""
        snapshot = self.newest if snapshot is None else snapshot
        by_id = {_id(behaviour.own_id): behaviour for behaviour in snapshot.behaviours}
        (root,) = (
            behaviour for behaviour in snapshot.behaviours if not any(behaviour.parent_id.uuid)
        )
        lines: list[str] = []

        def draw(behaviour: Behaviour, depth: int) -> None:
            line = f"{'  ' * depth}{TYPES[behaviour.type]} {behaviour.name}"
            if behaviour.is_active:
                line += f" [{SIGNS[behaviour.status]}]" + (
                    f" -- {behaviour.message}" if behaviour.message else ""
                )
            lines.append(line)
            for child in behaviour.child_ids:
                assert _id(by_id[_id(child)].parent_id) == _id(behaviour.own_id)
                draw(by_id[_id(child)], depth + 1)

        draw(root, 0)
        assert len(lines) == len(snapshot.behaviours)
        return lines


def _id(message: Any) -> UUID:
    """An id as the watcher reads it, which takes every id for a random one."""
    return UUID(bytes=bytes(message.uuid), version=4)
