"""The tree of a running mission as messages: itself once, and after that what changes.

Whoever takes them is an outlet: publishers (:mod:`bt_mission.ros.status_topics`), a recording.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from bt_mission_interfaces.msg import MissionState, NodeStatus, StatusChanges, Tree, TreeNode
from py_trees.common import Status

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour
    from rclpy.clock import Clock

    from bt_mission.executive.executive import Change, Executive

CODES = {
    Status.INVALID: NodeStatus.INVALID,
    Status.RUNNING: NodeStatus.RUNNING,
    Status.SUCCESS: NodeStatus.SUCCESS,
    Status.FAILURE: NodeStatus.FAILURE,
}

Outlet = Callable[[str, Any], None]
"""Takes a message with what it is: ``tree``, ``state`` or ``changes``."""


class StatusFeed:
    """Tells of one mission after another.

    :param clock: of the node of the missions, for the stamps.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._outlets: list[Outlet] = []
        self.run = ""
        """Names the run; empty before the first."""
        self.sequence = 0
        """Of the newest message of changes; 0 before the first."""
        self.indices: dict[Behaviour, int] = {}
        """The nodes of the tree, each with its number."""
        self._mission = ""
        self._executive: Executive | None = None
        self._is_told = False
        self._pending: list[NodeStatus] = []
        self._seen: tuple[str, str | None, str] | None = None
        self._shown: tuple[str, str] | None = None

    def add(self, outlet: Outlet) -> None:
        """Tell an outlet what has been told so far, and what changes from now on."""
        if self._outlets and self._is_told:
            self.flush()
        self._outlets.append(outlet)
        if self._is_told and self._executive is not None:
            outlet("tree", self._tree(self._executive))
        if self._shown is not None:
            outlet("state", self._state(*self._shown))

    def remove(self, outlet: Outlet) -> None:
        """Tell an outlet no more."""
        self._outlets.remove(outlet)

    def rest(self) -> None:
        """Tell that there is no mission yet."""
        self._tell_state("idle", "")

    def begin(self, mission: str, executive: Executive) -> None:
        """Follow a mission that starts.

        Its tree is told with the first :meth:`flush`: before its first tick a node on the stage
        does not have the mission's time yet.
        """
        self.run, self._mission = secrets.token_hex(8), mission
        self.sequence, self._executive = 0, executive
        self._pending = []
        self._is_told = False
        self.indices = {node: index for index, node in enumerate(executive.nodes)}
        executive.listeners.append(self._take)

    def flush(self) -> None:
        """Tell what has changed since the last time, if anything has; at first the tree."""
        self.turn()

    def turn(self) -> bool:
        """Flush; gives whether the mission has turned into another state."""
        if self._executive is None or not self._outlets:
            return False
        if not self._is_told:
            self._is_told = True
            self._tell("tree", self._tree(self._executive))
        if self._pending:
            self.sequence += 1
            changes = StatusChanges(
                stamp=self._clock.now().to_msg(),
                run=self.run,
                sequence=self.sequence,
                changes=self._pending,
            )
            self._pending = []
            self._tell("changes", changes)
        executive = self._executive
        seen = (executive.status, executive.paused, executive.reason)
        if seen == self._seen:
            return False
        self._seen = seen
        self._tell_state(executive.state, executive.paused or executive.reason)
        return True

    @property
    def statuses(self) -> list[NodeStatus]:
        """The status of every node, in the order of the tree."""
        return [
            _status(index, node.status, node.feedback_message)
            for node, index in self.indices.items()
        ]

    def _tell_state(self, status: str, reason: str) -> None:
        self._shown = (status, reason)
        self._tell("state", self._state(status, reason))

    def _tell(self, what: str, message: Any) -> None:
        for outlet in self._outlets:
            outlet(what, message)

    def _take(self, change: Change) -> None:
        if self._outlets:
            self._pending.append(_status(self.indices[change.node], change.status, change.message))

    def _tree(self, executive: Executive) -> Tree:
        return Tree(
            stamp=self._clock.now().to_msg(),
            run=self.run,
            mission=self._mission,
            nodes=[
                TreeNode(
                    name=node.name,
                    kind=type(node).__name__,
                    path=executive.path_of(node),
                    parent=self.indices[node.parent or node],
                )
                for node in self.indices
            ],
        )

    def _state(self, status: str, reason: str) -> MissionState:
        return MissionState(
            stamp=self._clock.now().to_msg(),
            run=self.run,
            mission=self._mission,
            status=status,
            reason=reason,
        )


def _status(index: int, status: Status, message: str) -> NodeStatus:
    return NodeStatus(node=index, status=CODES[status], message=message)
