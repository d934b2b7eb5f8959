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

from bt_mission.detail_topics import DetailTopics

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour
    from rclpy.node import Node

    from bt_mission.executive import Change, Executive
    from bt_mission.node import MissionNode

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
        self._details = DetailTopics(node)
        node.create_service(GetStatuses, "~/statuses", self._answer)
        self._run = ""
        self._mission = ""
        self._sequence = 0
        self._executive: Executive | None = None
        self._is_told = False
        self._indices: dict[Behaviour, int] = {}
        self._pending: list[NodeStatus] = []
        self._seen: tuple[str, str | None, str] | None = None

    def rest(self) -> None:
        """Tell that there is no mission yet."""
        self._publish_state("idle", "")

    def begin(self, mission: str, node: MissionNode) -> None:
        """Follow a mission that starts.

        Its tree is published with the first :meth:`flush`: before its first tick a node on the
        stage does not have the mission's time yet.
        """
        self._run, self._mission = secrets.token_hex(8), mission
        self._sequence, self._executive = 0, node.executive
        self._pending = []
        self._indices = {one: index for index, one in enumerate(node.executive.nodes)}
        self._is_told = False
        node.executive.listeners.append(self._take)
        self._details.begin(self._run, node, self._indices)

    def flush(self) -> None:
        """Publish what has changed since the last time, if anything has; at first the tree."""
        if self._executive is not None and not self._is_told:
            self._is_told = True
            self._publish_tree(self._executive)
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
        has_turned = False
        executive = self._executive
        if executive is not None:
            seen = (executive.status, executive.paused, executive.reason)
            has_turned = seen != self._seen
            if has_turned:
                self._seen = seen
                self._publish_state(executive.state, executive.paused or executive.reason)
        self._details.flush(at_once=has_turned)

    def _take(self, change: Change) -> None:
        self._pending.append(_status(self._indices[change.node], change.status, change.message))

    def _publish_tree(self, executive: Executive) -> None:
        self._tree.publish(
            Tree(
                stamp=self._clock.now().to_msg(),
                run=self._run,
                mission=self._mission,
                nodes=[
                    TreeNode(
                        name=one.name,
                        kind=type(one).__name__,
                        path=executive.path_of(one),
                        parent=self._indices[one.parent or one],
                    )
                    for one in self._indices
                ],
            )
        )

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
