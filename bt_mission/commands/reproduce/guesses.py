"""What had to be guessed of the faults: a space that the search of `falsify` draws from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bt_mission.commands.falsify.candidate import Candidate
from bt_mission.commands.falsify.space import PartDraws
from bt_mission.commands.reproduce.diagnosed import DiagnosedFault
from bt_mission.scenarios.faults.planned import AtTime, PlannedFault

SHIFTS_S = (0.0, -0.1, -0.05, 0.05, 0.1)
"""How much earlier or later a fault may have begun."""


class Guesses:
    """Draws for each fault what it was, when it began, and whether it was there at all."""

    def __init__(self, diagnosed: Sequence[DiagnosedFault]) -> None:
        self._diagnosed = diagnosed

    def as_it_is(self) -> tuple[PlannedFault, ...]:
        """Return the most likely faults."""
        return tuple(each.fault for each in self._diagnosed)

    @property
    def count(self) -> int:
        """The number of different choices, without those of times."""
        count = 1
        for each in self._diagnosed:
            count *= 1 + len(each.variants) + (not each.is_needed)
        return count

    def draw(self, parts: PartDraws) -> Candidate:
        """Draw a candidate; equal draws give equal candidates."""
        faults: list[PlannedFault] = []
        for number, each in enumerate(self._diagnosed):
            choices: list[PlannedFault | None] = [each.fault, *each.variants]
            choices += [] if each.is_needed else [None]
            chosen = choices[parts(f"fault {number}").whole(0, len(choices) - 1)]
            shift = SHIFTS_S[parts(f"time {number}").whole(0, len(SHIFTS_S) - 1)]
            if chosen is not None:
                faults.append(_shifted(chosen, shift))
        return Candidate(faults=tuple(faults))


def _shifted(fault: PlannedFault, by_s: float) -> PlannedFault:
    if not isinstance(fault.begins, AtTime) or not by_s:
        return fault
    return replace(fault, begins=AtTime(round(max(fault.begins.time_s + by_s, 0.0), 2)))
