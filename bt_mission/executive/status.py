"""The status of a mission, and the places of its nodes."""

from __future__ import annotations

from enum import StrEnum

from py_trees.behaviour import Behaviour

from bt_mission.executive.events.events import FINAL


class MissionStatus(StrEnum):
    """The state of a mission: while its tree can continue, while it ends, and its end.

    Attributes:
        is_active: Whether the tree runs, or can continue.
        is_final: Whether the mission has ended, with every goal accounted for.
    """

    RECOVERING = "recovering"
    """The goals that were in flight in the journal of a resumed mission are ended."""
    RUNNING = "running"
    PAUSED = "paused"
    ENDING = "ending"
    OBSERVING = "observing"
    """The mission has ended, and time continues for its requirements."""
    SUCCESS = "success"
    FAILURE = "failure"
    INTERRUPTED = "interrupted"

    is_active: bool
    is_final: bool

    def __init__(self, value: str) -> None:
        self.is_active = value in ("recovering", "running", "paused")
        self.is_final = value in FINAL


def node_paths(root: Behaviour) -> dict[Behaviour, str]:
    """Return every node of a tree, depth first, with its place, such as ``0.1.0``."""
    paths: dict[Behaviour, str] = {}
    stack = [(root, "0")]
    while stack:
        node, path = stack.pop()
        paths[node] = path
        stack += reversed([(child, f"{path}.{i}") for i, child in enumerate(node.children)])
    return paths
