"""A fault that a recording shows: what it is, when, why it is believed, and what it may also be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from bt_mission.base.text import seconds
from bt_mission.requirements.language.formula import CONTROL_STEP_S
from bt_mission.scenarios.faults.planned import AtTime, PlannedFault
from bt_mission.scenarios.faults.values import planned_fault


@dataclass(frozen=True)
class DiagnosedFault:
    """A fault with its evidence.

    Attributes:
        start: When it began, s since the start.
        end: When it ended; None for one that happens at once, or lasts to the end.
        confidence: From 0 to 1.
        variants: Other faults or arguments that would show in nearly the same way; the search
            chooses among these and the fault itself.
        is_needed: Whether the run cannot be repeated without it. The search also tries to leave
            out one that is not needed.
    """

    fault: PlannedFault
    evidence: str
    confidence: float
    start: float
    end: float | None = None
    variants: Sequence[PlannedFault] = ()
    is_needed: bool = True

    @property
    def name(self) -> str:
        """The row of the table of faults."""
        return self.fault.name

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "name": self.name,
            "fault": self.fault.text,
            "start": self.start,
            "end": self.end,
            "evidence": self.evidence,
            "confidence": round(self.confidence, 2),
        }

    def __str__(self) -> str:
        end = "" if self.end is None else f" to {seconds(self.end)}"
        return (
            f"{self.fault.text} (from {seconds(self.start)}{end}; {self.evidence}; confidence "
            f"{self.confidence:.0%})"
        )


def fault_at(
    start: float, kind: str, /, *arguments: Any, lasting: float | None = None, **named: Any
) -> PlannedFault:
    """Return a fault at a time, s; times are rounded to 0.01 s. It lasts a control step or more."""
    if lasting is not None:
        named["lasting"] = round(max(lasting, CONTROL_STEP_S), 2)
    return planned_fault(AtTime(round(max(start, 0.0), 2)), kind, *arguments, **named)
