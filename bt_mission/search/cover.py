"""Drives towards what of a mission's tree no run has reached yet."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from bt_mission.coverage.record import CoverageRecord
from bt_mission.search.candidate import Candidate
from bt_mission.search.material import material_of
from bt_mission.search.probing import present_in
from bt_mission.search.search import carry_out, run_as_it_is
from bt_mission.search.session import with_limit
from bt_mission.search.space import SearchSpace
from bt_mission.search.strategies import BATCH, STRATEGIES
from bt_mission.sweeps.base import BaseScenario
from bt_mission.sweeps.ranges import Ranges, RangesFile, Span
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.runner import ScenarioRunner

COVER_KINDS = ["servers", "network", "hardware", "messages"]
"""Faults that are drawn where the ranges name no kinds: outcomes of goals come from servers."""


LEAST_S = 0.25
"""The shortest fault, s."""


@dataclass
class CoverState:
    """What has been reached so far; it grows while the search runs.

    Attributes:
        record: What any run has reached.
        first: The scenarios that have reached something first, with what that was.
        errors: Scenarios that could not run.
    """

    record: CoverageRecord
    runs: int = 0
    errors: int = 0
    first_error: str = ""
    first: list[tuple[Candidate, ScenarioRow, tuple[str, ...]]] = field(default_factory=list)
    is_interrupted: bool = False

    def count(self, candidate: Candidate, row: ScenarioRow) -> int:
        """Take a run into account; gives how many places it has reached first."""
        self.runs += 1
        if row.is_error:
            self.errors += 1
            self.first_error = self.first_error or row.reason
        if not row.coverage:
            return 0
        if new := self.record.add(row.coverage):
            self.first.append((candidate, row, new))
        return len(new)


class CoverSession:
    """A search for what was not reached: `state` has what it has come to at any time.

    Args:
        base: What is varied.
        ranges: By how much.
        strategy: Of `STRATEGIES`.
        seed: The search follows from it.
        watch: Looks on after each run; False ends the search.
    """

    def __init__(
        self,
        base: BaseScenario,
        ranges: RangesFile,
        strategy: str,
        seed: int,
        watch: Callable[[CoverState], bool],
    ) -> None:
        self.base = base
        self.state = CoverState(CoverageRecord.of(base.mission))
        self._ranges = ranges
        self._strategy = strategy
        self._seed = seed
        self._watch = watch

    async def run(self, runner: ScenarioRunner, budget: int) -> None:
        """Search until everything is reached, or the budget is used up.

        Raises:
            BtMissionError: When the mission cannot run as it is.
        """
        state, ranges = self.state, self._ranges.ranges
        as_it_is = Candidate(limit=ranges.limit)
        row = await run_as_it_is(self.base, as_it_is, runner)
        state.count(as_it_is, row)
        state.is_interrupted = not self._watch(state)
        ranges = with_limit(_for_cover(ranges, row.virtual_s), self.base, row)
        material = await present_in(material_of(self.base.mission), self.base, runner)
        space = SearchSpace(self.base, ranges, self._ranges.parameters, row.virtual_s, material)
        strategy = STRATEGIES[self._strategy](space, self._seed)
        while state.runs < budget and state.record.missing and not state.is_interrupted:
            asked = strategy.ask(min(BATCH, budget - state.runs))
            scores: list[float] = []
            async for candidate, row in carry_out(self.base, runner, asked, state.runs):
                scores.append(-float(state.count(candidate, row)))
                state.is_interrupted = state.is_interrupted or not self._watch(state)
            strategy.tell(scores)


def _for_cover(ranges: Ranges, latest_s: float) -> Ranges:
    """Return ranges with what reaches more of a tree, where they do not say else.

    Some outcomes of goals take a server that is silent for long.
    """
    usual = {"kinds": COVER_KINDS, "lasting": Span(LEAST_S, max(LEAST_S, latest_s))}
    left = {key: one for key, one in usual.items() if key not in ranges.faults.model_fields_set}
    changes: dict[str, Any] = {"faults": ranges.faults.model_copy(update=left)}
    if "most" not in ranges.obstacles.model_fields_set:
        changes["obstacles"] = ranges.obstacles.model_copy(update={"most": 1})
    return ranges.model_copy(update=changes)
