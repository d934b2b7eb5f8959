"""Limits that are over, for people."""

from __future__ import annotations

from py_trees.behaviour import Behaviour

from bt_mission.behaviours.decorators import Retry
from bt_mission.behaviours.leaves import Wait

LIMITS = {
    "server": "waits for its server in vain",
    "answer": "waits for an answer to its goal in vain",
    "goal": "is not done in time",
    "silence": "gets no feedback in time",
    "cancel": "waits for the cancel in vain",
}
"""By the name of a limit of a goal."""


def words_of(node: Behaviour) -> str:
    """Return what happens when the limit of a node is over."""
    match node:
        case Wait():
            return f"'{node.name}' is over"
        case Retry():
            return f"the pause of '{node.name}' is over"
    return f"'{node.name}' is not done in time"
