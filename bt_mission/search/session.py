"""One search from its files to what it has found."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path

from bt_mission.core.diagnostics import Diagnostic, InputError
from bt_mission.search.guide import CLEARANCE, CLEARANCE_FORMULA, Aim, Guide, default_aim
from bt_mission.search.ranges import Ranges, RangesFile
from bt_mission.search.search import Found, Search, SearchState, Watch, run_as_it_is
from bt_mission.search.simplify import MOST_RUNS, simplify
from bt_mission.search.space import SearchSpace
from bt_mission.search.strategies import STRATEGIES
from bt_mission.sweeps.base import BaseChanges, BaseScenario, load_base
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.runner import ScenarioRunner
from bt_mission.sweeps.work import ScenarioWorker

RunnerFor = Callable[[BaseScenario], AbstractContextManager[ScenarioRunner]]

LONGER = 3.0
"""A run counts as one that never ends after so many times the time of the mission as it is."""

AT_LEAST_LONGER_S = 30.0


@dataclass(frozen=True)
class SearchOptions:
    """What is searched for, and how.

    Attributes:
        aim: None is a violated requirement where there are any, and else anything.
        budget: Runs at most; those that make a find small are counted apart.
        strategy: Of `STRATEGIES`.
        seed: The search follows from it.
        simplifying_runs: Runs at most that make a find small; 0 leaves it as it was found.
    """

    aim: Aim | None = None
    budget: int = 1000
    strategy: str = "optuna"
    seed: int = 0
    simplifying_runs: int = MOST_RUNS


def load_search(
    path: Path, changes: BaseChanges, ranges: RangesFile, aim: Aim | None
) -> BaseScenario:
    """Load what is varied, and check that the ranges fit it.

    Raises:
        InputError: With every error.
    """
    ranges.check_worlds(path)
    if aim in ("collision", "anything"):
        requirements = {**changes.requirements, CLEARANCE: CLEARANCE_FORMULA}
        changes = replace(changes, requirements=requirements)
    base = load_base(path, changes, ranges.parameters)
    ranges.check_inputs(base.mission)
    ranges.check_camera(base.mission)
    _check_ends(base, ranges)
    return base


def aim_of(base: BaseScenario, aim: Aim | None) -> Aim:
    """Return what is searched for."""
    has_requirements = bool(base.mission.requirements or base.data.get("requirements"))
    return aim or default_aim(has_requirements=has_requirements)


def _check_ends(base: BaseScenario, ranges: RangesFile) -> None:
    """Load the mission with the ends of each input."""
    wrong: list[Diagnostic] = []
    with ScenarioWorker(base.bundle) as worker:
        worker.load(base.concrete({}))  # as it is, before any other
        for one in ranges.parameters:
            if one.name == "world":
                continue
            for value in one.ends:
                try:
                    worker.load(base.concrete({one.name: value}))
                except InputError as error:
                    wrong.append(ranges.refused_value(one.name, error.faults[0].message))
                    break
    if wrong:
        raise InputError(wrong)


class SearchSession:
    """A search on its way: `state` has what it has come to at any time.

    Args:
        base: What is varied.
        ranges: By how much.
        options: How.
        watch: Looks on after each run.
    """

    def __init__(
        self, base: BaseScenario, ranges: RangesFile, options: SearchOptions, watch: Watch
    ) -> None:
        self.base = base
        self.aim = aim_of(base, options.aim)
        self.state = SearchState()
        self.as_it_is: ScenarioRow | None = None
        self._ranges = ranges
        self._options = options
        self._watch = watch

    async def run(self, runner: ScenarioRunner) -> None:
        """Search, and make what is found small.

        Raises:
            BtMissionError: When the mission cannot run as it is.
        """
        ranges, options, state = self._ranges.ranges, self._options, self.state
        space = SearchSpace(self.base, ranges, self._ranges.parameters, 0.0)
        row = await run_as_it_is(self.base, space.as_it_is(), runner)
        self.as_it_is = row
        guide = Guide(self.aim, row)
        state.count(row, guide)
        search = Search(self.base, runner, guide, state, self._watch)
        if failures := guide.failures(row):
            state.found = Found(space.as_it_is(), row, failures[0])
        elif self._watch(state):
            ranges = with_limit(ranges, self.base, row)
            space = SearchSpace(self.base, ranges, self._ranges.parameters, row.virtual_s)
            strategy = STRATEGIES[options.strategy](space, options.seed)
            await search.find(strategy, options.budget)
        else:
            state.is_interrupted = True
        if state.found and not state.is_interrupted and options.simplifying_runs:
            await simplify(search, space, options.simplifying_runs)


def with_limit(ranges: Ranges, base: BaseScenario, row: ScenarioRow) -> Ranges:
    """Return ranges with the time at which runs end, where neither they nor the base say it."""
    if ranges.limit is not None or "limit" in base.data:
        return ranges
    limit = math.ceil(max(LONGER * row.virtual_s, row.virtual_s + AT_LEAST_LONGER_S))
    return ranges.model_copy(update={"limit": float(limit)})
