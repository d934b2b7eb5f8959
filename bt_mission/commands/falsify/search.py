"""Runs candidates until one breaks the mission."""

from __future__ import annotations

from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import aclosing
from dataclasses import dataclass, field, replace

from bt_mission.commands.falsify.candidate import Candidate
from bt_mission.commands.falsify.guide import BEST, FoundFailure, Guide, is_hidden
from bt_mission.commands.falsify.reference import Reference
from bt_mission.commands.falsify.strategies import BATCH, Strategy
from bt_mission.scenarios.concrete.base_scenario import BaseScenario
from bt_mission.scenarios.concrete.row import ScenarioRow
from bt_mission.scenarios.concrete.worker import ScenarioRunner


@dataclass(frozen=True)
class Counterexample:
    """A candidate that breaks the mission, and how.

    Attributes:
        failure: The worst of what it shows.
        runs: How many runs of the search have shown the same.
    """

    candidate: Candidate
    row: ScenarioRow
    failure: FoundFailure
    runs: int = 1


@dataclass
class SearchState:
    """The progress of a search; it grows while the search runs.

    Attributes:
        runs: The number of scenarios that were run.
        errors: The number of them that could not run, for example because the world is full.
        first_error: The error of the first of them.
        is_interrupted: Whether the user has ended it.
        outside: Runs that violated an assumption.
        unfair: Runs that broke the reference mission, too.
        smallest: The smallest margin so far as a share of that of the mission as it is, and the
            requirement's name.
        counterexamples: One for each cause of a failure; minimized after the search.
        simplifying_runs: The number of scenarios that were run to minimize them.
        unexercised: The requirements whose premises came true in no run.
    """

    runs: int = 0
    errors: int = 0
    first_error: str = ""
    is_interrupted: bool = False
    outside: int = 0
    unfair: int = 0
    smallest: tuple[float, str] | None = None
    counterexamples: list[Counterexample] = field(default_factory=list)
    simplifying_runs: int = 0
    unexercised: tuple[str, ...] = ()

    def count(self, row: ScenarioRow, guide: Guide) -> None:
        """Take a run of the search into account."""
        self.runs += 1
        if row.is_error:
            self.errors += 1
            self.first_error = self.first_error or row.reason
        vacuous = [name for name in row.unexercised if not is_hidden(name)]
        known = vacuous if self.runs == 1 else self.unexercised
        self.unexercised = tuple(name for name in known if name in vacuous)
        self.outside += not row.is_error and not guide.is_assumed(row)
        smallest = guide.smallest(row)
        if smallest is not None and (self.smallest is None or smallest < self.smallest):
            self.smallest = smallest

    def add(self, candidate: Candidate, row: ScenarioRow, failure: FoundFailure) -> None:
        """Count a counterexample by its cause, and keep the smallest candidate of each cause."""
        for number, known in enumerate(self.counterexamples):
            if known.failure == failure:
                kept = replace(known, runs=known.runs + 1)
                if candidate.size < known.candidate.size:
                    kept = replace(kept, candidate=candidate, row=row)
                self.counterexamples[number] = kept
                return
        self.counterexamples.append(Counterexample(candidate, row, failure))


Watch = Callable[[SearchState], bool]
"""Called after each run; returns False to end the search."""


@dataclass(frozen=True)
class Search:
    """The parts of a search that run candidates.

    Attributes:
        base: The scenario that is varied.
        runner: Runs scenarios.
        guide: Scores them.
        state: The progress.
        watch: Called after each run.
        reference: A mission that a counterexample must not break.
    """

    base: BaseScenario
    runner: ScenarioRunner
    guide: Guide
    state: SearchState
    watch: Watch
    reference: Reference | None = None

    async def find(self, strategy: Strategy, budget: int, causes: int = 1) -> None:
        """Run candidates until enough causes are found, or the budget is used up.

        The first counterexample in the order of the candidates counts, whichever run ended first.

        Args:
            budget: The most runs of the state, including earlier ones.
            causes: The number of different causes.
        """
        state = self.state
        while state.runs < budget:
            asked = strategy.ask(min(BATCH, budget - state.runs))
            scores: list[float] = []
            async with aclosing(run_all(self.base, self.runner, asked, state.runs)) as tried:
                async for candidate, row in tried:
                    scores.append(await self._take(candidate, row, causes))
                    if len(state.counterexamples) >= causes or state.is_interrupted:
                        return
            strategy.learn(scores)

    async def _take(self, candidate: Candidate, row: ScenarioRow, causes: int) -> float:
        """Take a run. Return its score."""
        state = self.state
        state.count(row, self.guide)
        failures = self.guide.failures(row)
        is_fair = not failures or await self.is_fair(candidate)
        if failures and is_fair:
            state.add(candidate, row, failures[0])
        state.unfair += not is_fair
        # A known failure, or one of any mission, is not a target.
        is_far = failures and (causes > 1 or not is_fair)
        score = BEST if is_far else self.guide.score(row)
        self.guide.learn(row)
        state.is_interrupted = not self.watch(state)
        return score

    async def is_fair(self, candidate: Candidate) -> bool:
        """Return whether the reference passes where the mission breaks; True without one."""
        return self.reference is None or await self.reference.passes(candidate, self.guide)


async def run_all(
    base: BaseScenario, runner: ScenarioRunner, candidates: Sequence[Candidate], first: int
) -> AsyncGenerator[tuple[Candidate, ScenarioRow], None]:
    """Run candidates. Yields each with its row, in their order.

    Args:
        first: The number of the first.
    """
    made = [candidate.concrete(base, first + n) for n, candidate in enumerate(candidates)]
    ended: dict[int, ScenarioRow] = {}
    due = 0
    async with aclosing(runner.rows(made)) as rows:
        async for row in rows:
            ended[row.number - first] = row
            while due in ended:
                yield candidates[due], ended.pop(due)
                due += 1
