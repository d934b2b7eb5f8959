"""Where a mission stands, the places and changes of its nodes, and why its tree has failed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from py_trees.behaviour import Behaviour
from py_trees.common import Status


class MissionStatus(StrEnum):
    """Where a mission stands; the last three are final."""

    RUNNING = "running"
    ENDING = "ending"
    OBSERVING = "observing"
    """It has ended, and time goes on for its requirements."""
    SUCCESS = "success"
    FAILURE = "failure"
    INTERRUPTED = "interrupted"


@dataclass(frozen=True)
class Change:
    """A node of the tree changed its status."""

    time_ns: int
    node: Behaviour
    path: str
    status: Status
    message: str


def node_paths(root: Behaviour) -> dict[Behaviour, str]:
    """Return every node of a tree, depth first, with its place, such as ``0.1.0``."""
    paths: dict[Behaviour, str] = {}
    stack = [(root, "0")]
    while stack:
        node, path = stack.pop()
        paths[node] = path
        stack += reversed([(child, f"{path}.{i}") for i, child in enumerate(node.children)])
    return paths


def failed_node(root: Behaviour) -> Behaviour:
    """Return which node made a tree fail; the root where that is not known.

    Where no leaf has failed, a node above them has by itself: the first and lowest.
    """
    failed = [node for node in root.iterate() if node.status is Status.FAILURE]
    leaves = [node for node in failed if not node.children]
    tip = root.tip()
    culprit = tip if tip is not None and tip.status is Status.FAILURE else None
    if culprit is None and failed:
        culprit = leaves[-1] if leaves else failed[0]
    return root if culprit is None else culprit
