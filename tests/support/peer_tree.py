"""A tree as py_trees_ros offers it, for watchers: services, a topic for each stream, snapshots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from py_trees_ros_interfaces.msg import Behaviour, BehaviourTree
from py_trees_ros_interfaces.srv import (
    CloseSnapshotStream,
    OpenSnapshotStream,
    ReconfigureSnapshotStream,
)
from rclpy.node import Node
from unique_identifier_msgs.msg import UUID

from tests.support.tree_watcher import LATCHED

TREE = (("leaf", "root", ()), ("root", "", ("leaf",)))
"""Name, parent and children of each node."""


def uid(name: str) -> UUID:
    """An id of a name; that of no name is zeros."""
    return UUID(uuid=list(name.encode().ljust(16, b"\0")))


class PeerTree:
    """Offers the services of a tree on a node; the test says what comes.

    Args:
        node: Such as ``/tree``.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.streams: dict[str, Any] = {}
        self.asked: list[Any] = []
        self.refuses = False
        self._told: tuple[int, str, Sequence[tuple[str, str, Sequence[str]]]] = (
            Behaviour.RUNNING,
            "",
            TREE,
        )
        self._count = 0
        self._services = [
            node.create_service(kind, f"~/snapshot_streams/{name}", serve)
            for kind, name, serve in (
                (OpenSnapshotStream, "open", self._open),
                (CloseSnapshotStream, "close", self._close),
                (ReconfigureSnapshotStream, "reconfigure", lambda _, answer: answer),
            )
        ]

    def tell(
        self,
        status: int = Behaviour.RUNNING,
        message: str = "",
        nodes: Sequence[tuple[str, str, Sequence[str]]] = TREE,
    ) -> None:
        """Send a snapshot on all streams, with this of every node; new streams begin with it."""
        self._told = (status, message, nodes)
        tree = BehaviourTree(
            behaviours=[
                Behaviour(
                    name=name,
                    class_name=f"py_trees.behaviours.{name.capitalize()}",
                    own_id=uid(name),
                    parent_id=uid(parent),
                    child_ids=[uid(child) for child in below],
                    type=Behaviour.SEQUENCE if below else Behaviour.BEHAVIOUR,
                    status=status,
                    message=message,
                    is_active=True,
                )
                for name, parent, below in nodes
            ]
        )
        tree.statistics.stamp = self._node.get_clock().now().to_msg()
        for publisher in self.streams.values():
            publisher.publish(tree)

    def drop_streams(self) -> None:
        """Forget every stream, as a process that begins anew."""
        while self.streams:
            self._node.destroy_publisher(self.streams.popitem()[1])

    def leave(self) -> None:
        """Offer nothing any more."""
        self.drop_streams()
        while self._services:
            self._node.destroy_service(self._services.pop())

    def _open(self, request: Any, answer: Any) -> Any:
        self.asked.append(request)
        if self.refuses:
            return answer
        name = f"{self._node.get_fully_qualified_name()}/snapshot_streams/_snapshots_{self._count}"
        self._count += 1
        self.streams[name] = self._node.create_publisher(BehaviourTree, name, LATCHED)
        answer.topic_name = name
        self.tell(*self._told)
        return answer

    def _close(self, request: Any, answer: Any) -> Any:
        publisher = self.streams.pop(request.topic_name, None)
        answer.result = publisher is not None
        if publisher is not None:
            self._node.destroy_publisher(publisher)
        return answer
