"""What the checks ask of those who know the servers: this package knows no server."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Protocol

from bt_mission.core.diagnostics import Diagnostic
from bt_mission.core.yaml.document import Document
from bt_mission.language.nodes.interfaces import InterfaceNode

Ranges = Mapping[str, tuple[float, float]]
"""From where to where numbers can go, by their names."""


class GoalRules(Protocol):
    """What is known of goals before they are sent.

    `values` are the fields of a goal as their message holds them, those that are not written as 0,
    false or empty; None stands for a value that only the run can tell.
    """

    def faults(
        self, document: Document, node: InterfaceNode, values: Mapping[str, Any]
    ) -> Iterable[Diagnostic]:
        """Return why a server refuses the goal of a node, and what is suspicious in it."""

    def feedback(self, node: InterfaceNode, values: Mapping[str, Any]) -> Ranges:
        """Return from where to where the numbers of the feedback can go."""
