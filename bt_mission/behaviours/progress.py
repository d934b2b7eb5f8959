"""How far a running leaf has come."""

from __future__ import annotations

from dataclasses import dataclass

from py_trees.behaviour import Behaviour
from py_trees.common import Status


@dataclass(frozen=True)
class LeafProgress:
    """How far a running leaf has come towards something that ends it.

    Args:
        label: What is measured: a field of the feedback, or ``s`` for the leaf's time.
    """

    label: str
    value: float
    limit: float


def progress_of(node: Behaviour) -> LeafProgress | None:
    """The ``progress`` of a node that runs, where it has one."""
    if node.status is not Status.RUNNING:
        return None
    progress = getattr(node, "progress", None)
    return progress if isinstance(progress, LeafProgress) else None
