"""What the requirements of a mission have come to, as diagnostics of ROS."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from bt_mission.core.stamps import NS, set_ns
from bt_mission.requirements.monitor import RequirementResult

PERIOD_NS = NS
"""Margins are as new as this, in the mission's time; a violation is told at once."""

LEVELS = {
    "holds": DiagnosticStatus.OK,
    "open": DiagnosticStatus.OK,
    "unknown": DiagnosticStatus.WARN,
    "violated": DiagnosticStatus.ERROR,
}


class RequirementStatus:
    """Describes the requirements of one mission, whenever that is due.

    Args:
        run: Names the run.
        results: Returns what they have come to.
        count_violated: Returns how many are known to be violated; asked at each control step.
    """

    def __init__(
        self,
        run: str,
        results: Callable[[], tuple[RequirementResult, ...]],
        count_violated: Callable[[], int],
    ) -> None:
        self.message: DiagnosticArray | None = None
        """The newest; None where there is none yet."""
        self._run = run
        self._results = results
        self._count_violated = count_violated
        self._violated = 0
        self._told: dict[str, RequirementResult] = {}
        self._statuses: dict[str, DiagnosticStatus] = {}
        self._next_ns = 0

    def describe(self, now_ns: int, *, is_done: bool) -> DiagnosticArray | None:
        """Return a message with all of them, if one is due and something has changed.

        Args:
            now_ns: The mission's time, ns.
            is_done: Has the mission ended?
        """
        violated = self._count_violated()
        if now_ns < self._next_ns and violated == self._violated and not is_done:
            return None
        self._next_ns, self._violated = now_ns + PERIOD_NS, violated
        changed = [one for one in self._results() if self._told.get(one.name) != one]
        if not changed:
            return None
        for one in changed:
            self._told[one.name] = one
            self._statuses[one.name] = _status(one, self._run)
        self.message = DiagnosticArray(status=list(self._statuses.values()))
        set_ns(self.message.header.stamp, now_ns)
        return self.message


def _status(result: RequirementResult, run: str) -> DiagnosticStatus:
    values: dict[str, Any] = {
        "run": run,
        "requirement": result.requirement,
        "verdict": result.verdict,
        "margin": result.margin,
        "unit": result.unit,
        "at": result.at,
        "violated_at": result.violated_at,
        "on_violation": result.on_violation,
        "sources": "; ".join(result.sources),
        "why": result.why,
    }
    return DiagnosticStatus(
        level=LEVELS[result.verdict],
        name=result.name,
        message=result.outcome,
        values=[
            KeyValue(key=key, value=str(value))
            for key, value in values.items()
            if value not in (None, "")
        ],
    )
