"""What people are shown of the nodes of a tree, and the way down to what made it fail.

py_trees takes back the status of nodes that have ended: a fallback that goes on to its next child
resets those before it, and a halted tree all of its nodes. People want to know what came of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.executive.status import Change


@dataclass(frozen=True)
class NodeState:
    """What a node does, or how it ended when it last ran.

    Attributes:
        since_ns: ROS time since when; None where it has not run.
    """

    status: Status
    message: str = ""
    since_ns: int | None = None


NOT_RUN = NodeState(Status.INVALID)


class NodeStates:
    """Keeps the state of each node until what it is part of starts anew.

    What runs when the mission ends is kept as running.

    Args:
        root: The tree.
        is_running: Does the mission run, or is it being halted or over?
    """

    def __init__(self, root: Behaviour, is_running: Callable[[], bool]) -> None:
        self._root = root
        self._is_running = is_running
        self._states: dict[Behaviour, NodeState] = {}
        self._started_ns: dict[Behaviour, int] = {}

    def on_change(self, change: Change) -> None:
        """Take in that a node has changed its status."""
        if change.status is Status.INVALID and not self._is_running():
            return
        if change.status is Status.RUNNING:
            self._started_ns[change.node] = change.time_ns
        self._states[change.node] = NodeState(change.status, change.message, change.time_ns)

    def keep_visited(
        self, walk: Iterator[Behaviour], now_ns: Callable[[], int]
    ) -> Iterator[Behaviour]:
        """Wrap a tick, to see what is no change of status.

        A node that ends as it ended before, and what a node that goes on running says of itself.
        """
        for node in walk:
            since_ns = now_ns()
            if node.status is Status.RUNNING:
                since_ns = self._started_ns.get(node, since_ns)
            self._states[node] = NodeState(node.status, node.feedback_message, since_ns)
            yield node

    def walk(self) -> Iterator[tuple[Behaviour, int, NodeState]]:
        """Every node, depth first, with its depth and its state."""
        stack = [(self._root, 0, 0)]
        while stack:
            node, depth, since_ns = stack.pop()
            yield node, depth, self._state(node, since_ns)
            since_ns = max(since_ns, self._started_ns.get(node, 0))
            stack += [(child, depth + 1, since_ns) for child in reversed(node.children)]

    def failure_path(self) -> list[tuple[Behaviour, NodeState]]:
        """The nodes from the root down to the one whose failure came last.

        Empty where the tree has not failed.
        """
        state = self._state(self._root, 0)
        if state.status is not Status.FAILURE:
            return []
        path = [(self._root, state)]
        since_ns = 0
        while True:
            node, state = path[-1]
            since_ns = max(since_ns, self._started_ns.get(node, 0))
            below = [(child, self._state(child, since_ns)) for child in node.children]
            failed = [
                (child.status is Status.FAILURE, one.since_ns or 0, number)
                for number, (child, one) in enumerate(below)
                if one.status is Status.FAILURE
            ]
            if not failed:
                return path
            path.append(below[max(failed)[2]])

    def _state(self, node: Behaviour, since_ns: int) -> NodeState:
        """Return the state of a node: the present one, or the one it had at this time or later."""
        state = self._states.get(node, NOT_RUN)
        if node.status is not Status.INVALID:
            return NodeState(node.status, node.feedback_message, state.since_ns)
        return NOT_RUN if state.since_ns is None or state.since_ns < since_ns else state
