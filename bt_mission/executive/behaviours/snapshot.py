"""The memory of a running node as plain data, from which another process can continue.

A behaviour with more to remember than its status and its children's has two methods:
``save_state(now_ns)`` returns it as a dictionary of plain data, with points in time as nanoseconds
from now, and ``restore_state(state, now_ns)`` takes it back. Of py_trees' composites it is the
child that they have reached. A leaf without these methods starts again.
"""

from __future__ import annotations

from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite
from py_trees.decorators import Decorator


def save(node: Behaviour, now_ns: int) -> dict[str, Any]:
    """Return the memory of a running node."""
    state: dict[str, Any] = {}
    if isinstance(node, Composite) and node.current_child is not None:
        state["child"] = node.children.index(node.current_child)
    save_state = getattr(node, "save_state", None)
    if save_state is not None:
        state |= save_state(now_ns)
    return state


def load(node: Behaviour, status: Status, state: dict[str, Any], now_ns: int) -> None:
    """Restore a node that was never ticked from the saved state of another node of its kind."""
    restore_state = getattr(node, "restore_state", None)
    if status is not Status.RUNNING:
        node.status = status
        if state and restore_state is not None:
            restore_state(state, now_ns)
        return
    if isinstance(node, Composite) and "child" in state:
        node.current_child = node.children[state["child"]]
    if isinstance(node, Composite | Decorator) or restore_state is not None:
        node.status = Status.RUNNING
    if restore_state is not None:
        restore_state(state, now_ns)
