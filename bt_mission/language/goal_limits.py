"""Limits of goals: a node's own come first, then its server's, then the mission's, then ours."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic import BaseModel

from bt_mission.base.diagnostics import Diagnostic, did_you_mean, listed, quoted
from bt_mission.base.yaml.document import Document
from bt_mission.language.action_names import ACTION_NAMES

DEFAULTS: Mapping[str, float] = {
    "server_timeout": 5.0,
    "acceptance_timeout": 2.0,
    "cancel_timeout": 3.0,
}
"""Seconds, where nobody says anything; the others are then no limit."""


def plain_name(name: str) -> str:
    """Return the name of an action without leading slashes, a short name as its action."""
    short = ACTION_NAMES.get(name)
    return (short.name if short else name).strip("/")


@dataclass(frozen=True)
class GoalLimitsTable:
    """The limits that a mission sets for goals of an action."""

    mission: Mapping[str, Any] = field(default_factory=dict)
    servers: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @classmethod
    def written(cls, file: Any) -> GoalLimitsTable:
        """Return what the head of a file says (`file.MissionFile`)."""
        servers = {plain_name(name): _given(limits) for name, limits in file.servers.items()}
        return cls(_given(file.limits), servers)

    def of(self, action: str) -> Mapping[str, Any]:
        """Return the limits of goals of an action, by the names of their modifiers."""
        return {**DEFAULTS, **self.mission, **self.servers.get(plain_name(action), {})}


def server_diagnostics(
    document: Document, servers: Iterable[str], actions: Iterable[str]
) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each server at the head of a file to which no goal is sent."""
    used = dict.fromkeys(plain_name(action) for action in actions)
    for name in servers:
        if plain_name(name) not in used:
            known = listed(used) if used else "none"
            message = f"the mission sends no goals to {quoted(name)} (but to: {known})"
            hint = did_you_mean(plain_name(name), used)
            yield document.diagnostic("BT-512", ("servers", name), message, hint, key=True)


def _given(limits: BaseModel) -> Mapping[str, Any]:
    return {name: value for name, value in limits if value is not None}
