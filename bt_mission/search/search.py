"""Tries candidates until one breaks the mission."""

from __future__ import annotations

from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import aclosing
from dataclasses import dataclass

from bt_mission.core.errors import BtMissionError
from bt_mission.search.candidate import Candidate
from bt_mission.search.guide import Failure, Guide
from bt_mission.search.strategies import BATCH, Strategy
from bt_mission.sweeps.base import BaseScenario
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.runner import ScenarioRunner


@dataclass(frozen=True)
class Found:
    """A candidate that breaks the mission, and how.

    Attributes:
        failure: The worst of what it shows.
    """

    candidate: Candidate
    row: ScenarioRow
    failure: Failure


@dataclass
class SearchState:
    """How far a search is; it grows while that runs.

    Attributes:
        runs: Scenarios that were carried out.
        errors: Those among them that could not run, such as an obstacle where something stands.
        first_error: Why the first of them could not.
        smallest: The smallest margin so far as a share of that of the mission as it is, and the
            requirement's name.
        found: What was found; made smaller later.
        simplifying_runs: Scenarios that were carried out to make it small.
        is_interrupted: Has somebody ended it?
    """

    runs: int = 0
    errors: int = 0
    first_error: str = ""
    smallest: tuple[float, str] | None = None
    found: Found | None = None
    simplifying_runs: int = 0
    is_interrupted: bool = False

    def count(self, row: ScenarioRow, guide: Guide) -> None:
        """Take a run of the search into account."""
        self.runs += 1
        if row.is_error:
            self.errors += 1
            self.first_error = self.first_error or row.reason
        smallest = guide.smallest(row)
        if smallest is not None and (self.smallest is None or smallest < self.smallest):
            self.smallest = smallest


Watch = Callable[[SearchState], bool]
"""Looks on after each run; False ends the search."""


@dataclass(frozen=True)
class Search:
    """What is needed to try candidates.

    Attributes:
        base: What is varied.
        runner: Carries scenarios out.
        guide: Judges them.
        state: How far it is.
        watch: Looks on.
    """

    base: BaseScenario
    runner: ScenarioRunner
    guide: Guide
    state: SearchState
    watch: Watch

    async def find(self, strategy: Strategy, budget: int) -> None:
        """Try candidates until one breaks the mission, or the budget is used up.

        What is found is the first in the order of asking, whatever ended first.

        Args:
            budget: Runs of the state at most, those that it has already included.
        """
        state = self.state
        while state.runs < budget and not state.is_interrupted:
            asked = strategy.ask(min(BATCH, budget - state.runs))
            scores: list[float] = []
            async with aclosing(self.tried(asked, state.runs)) as tried:
                async for candidate, row in tried:
                    state.count(row, self.guide)
                    scores.append(self.guide.score(row))
                    if failures := self.guide.failures(row):
                        state.found = Found(candidate, row, failures[0])
                    state.is_interrupted = not self.watch(state)
                    if state.found or state.is_interrupted:
                        return
            strategy.tell(scores)

    def tried(
        self, candidates: Sequence[Candidate], first: int
    ) -> AsyncGenerator[tuple[Candidate, ScenarioRow], None]:
        """Carry candidates out; yields each with its row, in their order."""
        return carry_out(self.base, self.runner, candidates, first)


async def carry_out(
    base: BaseScenario, runner: ScenarioRunner, candidates: Sequence[Candidate], first: int
) -> AsyncGenerator[tuple[Candidate, ScenarioRow], None]:
    """Carry candidates out; yields each with its row, in their order.

    Args:
        first: The number of the first.
    """
    made = [one.concrete(base, first + n) for n, one in enumerate(candidates)]
    ended: dict[int, ScenarioRow] = {}
    due = 0
    async with aclosing(runner.rows(made)) as rows:
        async for row in rows:
            ended[row.number - first] = row
            while due in ended:
                yield candidates[due], ended.pop(due)
                due += 1


async def run_as_it_is(
    base: BaseScenario, candidate: Candidate, runner: ScenarioRunner
) -> ScenarioRow:
    """Carry the mission out with nothing varied.

    Raises:
        BtMissionError: When it cannot run.
    """
    async for row in runner.rows([candidate.concrete(base, 0)]):
        if row.is_error:
            raise BtMissionError(f"{base.path}: cannot run as it is: {row.reason}")
        return row
    raise BtMissionError(f"{base.path}: nothing came of the run of the mission as it is")
