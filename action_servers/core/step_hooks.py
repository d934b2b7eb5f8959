"""What comes between the pilot and a maneuver, so that a test can have it fail: pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Literal, TypeAlias

from action_servers.core.maneuver import Finished, Maneuver, Observation, Value
from bt_mission.core.geometry import Twist2D

Method: TypeAlias = Literal["step", "feedback", "result"]

Before: TypeAlias = Callable[[Method, "Mapping[str, Value]"], "tuple[int, str] | None"]
"""Called before a method of a maneuver, with the newest feedback; whatever it raises, the maneuver
raises. Before a step, a code and a reason end the goal as aborted."""


class HookedManeuver:
    """A maneuver that others may have fail. `before` may change while it runs."""

    def __init__(self, maneuver: Maneuver, before: Sequence[Before]) -> None:
        self._maneuver = maneuver
        self._before = before
        self._feedback: Mapping[str, Value] = {}

    @property
    def needs_base(self) -> bool:
        """As the maneuver."""
        return self._maneuver.needs_base

    def step(self, now: Observation) -> Twist2D | Finished:
        """As the maneuver, or the end of the goal."""
        return self._ask("step") or self._maneuver.step(now)

    def feedback(self) -> Mapping[str, Value] | None:
        """As the maneuver."""
        self._ask("feedback")
        fields = self._maneuver.feedback()
        if fields is not None:
            self._feedback = fields
        return fields

    def result(self) -> Mapping[str, Value]:
        """As the maneuver."""
        self._ask("result")
        return self._maneuver.result()

    def _ask(self, method: Method) -> Finished | None:
        for before in tuple(self._before):
            end = before(method, self._feedback)
            if end is not None:
                return Finished("aborted", *end)
        return None
