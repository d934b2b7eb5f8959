"""The status of a mission, and the places of its nodes."""

from __future__ import annotations

from enum import StrEnum

from py_trees.behaviour import Behaviour


class MissionStatus(StrEnum):
    """The state of a mission; the last three are final."""

    RUNNING = "running"
    ENDING = "ending"
    OBSERVING = "observing"
    """The mission has ended, and time continues for its requirements."""
    SUCCESS = "success"
    FAILURE = "failure"
    INTERRUPTED = "interrupted"


def node_paths(root: Behaviour) -> dict[Behaviour, str]:
    """Return every node of a tree, depth first, with its place, such as ``0.1.0``."""
    paths: dict[Behaviour, str] = {}
    stack = [(root, "0")]
    while stack:
        node, path = stack.pop()
        paths[node] = path
        stack += reversed([(child, f"{path}.{i}") for i, child in enumerate(node.children)])
    return paths
