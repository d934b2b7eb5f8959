"""Where a mission stands, and a change of one of its nodes."""

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
