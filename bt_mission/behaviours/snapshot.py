"""What a node remembers while it runs, as plain data, so that another process can go on from it.

Our own behaviours say it themselves (:class:`Snapshotable`); of py_trees' composites it is the
child that they have come to. A leaf that says nothing starts anew.
"""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite
from py_trees.decorators import Decorator


@runtime_checkable
class Snapshotable(Protocol):
    """A behaviour with more to remember than its status and its children's."""

    def save_state(self, now_ns: int) -> dict[str, Any]:
        """What it needs to go on, as plain data; points in time as nanoseconds from now."""

    def restore_state(self, state: dict[str, Any], now_ns: int) -> None:
        """Take in what it remembered."""


def save(node: Behaviour, now_ns: int) -> dict[str, Any]:
    """What a running node remembers."""
    state: dict[str, Any] = {}
    if isinstance(node, Composite) and node.current_child is not None:
        state["child"] = node.children.index(node.current_child)
    if isinstance(node, Snapshotable):
        state |= node.save_state(now_ns)
    return state


def load(node: Behaviour, status: Status, state: dict[str, Any], now_ns: int) -> None:
    """Put a node that was never ticked where another one of its kind stood."""
    if status is not Status.RUNNING:
        node.status = status
        if state and isinstance(node, Snapshotable):
            node.restore_state(state, now_ns)
        return
    if isinstance(node, Composite) and "child" in state:
        node.current_child = node.children[state["child"]]
    if isinstance(node, Composite | Decorator | Snapshotable):
        node.status = Status.RUNNING
    if isinstance(node, Snapshotable):
        node.restore_state(state, now_ns)
