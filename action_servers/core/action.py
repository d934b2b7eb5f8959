"""An action that the servers offer: its name and type, and the plan for its goals."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any

from action_servers.core.maneuver import Maneuver, Observation, Refusal


def _nothing(_maneuver: Maneuver, _goal_id: str) -> AbstractContextManager[None]:
    return nullcontext()


@dataclass(frozen=True, slots=True)
class Action:
    """An action that the servers offer.

    Args:
        name: Its name, relative to the namespace of the servers.
        type: Its generated type. Where a result has `error_code` and `error_msg`, they tell how
            the goal ended.
        plan: Checks a goal message against what is known of the robot; returns the maneuver that
            carries it out, or why it is refused.
        needs_map: Whether its observations hold the map, and the robot's pose on it.
        during: Entered when a goal is accepted, with its maneuver and its id (32 hexadecimal
            digits), and left at its end.
    """

    name: str
    type: Any
    plan: Callable[[Any, Observation], Maneuver | Refusal]
    needs_map: bool = False
    during: Callable[[Any, str], AbstractContextManager[None]] = _nothing
