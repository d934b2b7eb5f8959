"""What tools see of a running mission: its tree once, and after that what changes.

``~/tree`` and ``~/state`` are latched; ``~/changes`` carries the changes of one tick, and nothing
is sent for a tick that changes nothing. Who comes late asks ``~/statuses`` for all statuses at
once, and goes on from its sequence number.
"""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING, Any

from bt_mission_interfaces.msg import MissionState, NodeStatus, StatusChanges, Tree, TreeNode
from bt_mission_interfaces.srv import GetStatuses
from py_trees.common import Status
from rclpy.qos import DurabilityPolicy, QoSProfile

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour
    from rclpy.node import Node

    from bt_mission.executive import Change, Executive

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
CHANGES = QoSProfile(depth=100)

CODES = {
    Status.INVALID: NodeStatus.INVALID,
    Status.RUNNING: NodeStatus.RUNNING,
    Status.SUCCESS: NodeStatus.SUCCESS,
    Status.FAILURE: NodeStatus.FAILURE,
}


class StatusTopics:
    """Publishes the tree and the statuses of one mission after another.

    :param node: owns the topics; their names begin with its own.
    """

    def __init__(self, node: Node) -> None:
        self._clock = node.get_clock()
        self._tree = node.create_publisher(Tree, "~/tree", LATCHED)
        self._state = node.create_publisher(MissionState, "~/state", LATCHED)
        self._changes = node.create_publisher(StatusChanges, "~/changes", CHANGES)
        node.create_service(GetStatuses, "~/statuses", self._answer)
        self._run = ""
        self._mission = ""
        self._sequence = 0
        self._executive: Executive | None = None
        self._indices: dict[Behaviour, int] = {}
        self._pending: list[NodeStatus] = []
        self._shown: tuple[str, str] = ("idle", "")
        self._publish_state(*self._shown)

    def begin(self, mission: str, executive: Executive) -> None:
        """Publish the tree of a mission that starts, and follow it."""
        self._run, self._mission = secrets.token_hex(8), mission
        self._sequence, self._executive = 0, executive
        self._pending = []
        nodes = executive.nodes
        self._indices = {node: index for index, node in enumerate(nodes)}
        self._tree.publish(
            Tree(
                stamp=self._clock.now().to_msg(),
                run=self._run,
                mission=mission,
                nodes=[
                    TreeNode(
                        name=node.name,
                        kind=type(node).__name__,
                        path=executive.path_of(node),
                        parent=self._indices[node.parent or node],
                    )
                    for node in nodes
                ],
            )
        )
        executive.listeners.append(self._take)
        self.flush()

    def flush(self) -> None:
        """Publish what has changed since the last time, if anything has."""
        if self._pending:
            self._sequence += 1
            self._changes.publish(
                StatusChanges(
                    stamp=self._clock.now().to_msg(),
                    run=self._run,
                    sequence=self._sequence,
                    changes=self._pending,
                )
            )
            self._pending = []
        if self._executive is not None:
            shown = (self._executive.state, self._executive.paused or self._executive.reason)
            if shown != self._shown:
                self._shown = shown
                self._publish_state(*shown)

    def _take(self, change: Change) -> None:
        self._pending.append(_status(self._indices[change.node], change.status, change.message))

    def _publish_state(self, status: str, reason: str) -> None:
        self._state.publish(
            MissionState(
                stamp=self._clock.now().to_msg(),
                run=self._run,
                mission=self._mission,
                status=status,
                reason=reason,
            )
        )

    def _answer(self, _request: Any, answer: Any) -> Any:
        self.flush()
        answer.run, answer.sequence = self._run, self._sequence
        answer.statuses = [
            _status(index, node.status, node.feedback_message)
            for node, index in self._indices.items()
        ]
        return answer


def _status(index: int, status: Status, message: str) -> NodeStatus:
    return NodeStatus(node=index, status=CODES[status], message=message)
