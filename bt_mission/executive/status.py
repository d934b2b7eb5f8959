"""Where a mission stands, a change of one of its nodes, and why its tree has failed."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from py_trees.behaviour import Behaviour
from py_trees.common import Status


class MissionStatus(StrEnum):
    """Where a mission stands; the last three are final."""

    RUNNING = "running"
    ENDING = "ending"
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
