"""One search from its files to what it has found."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from bt_mission.search.candidate import Candidate
from bt_mission.search.guide import (
    ASSUMED,
    BRANCH,
    CLEARANCE,
    CLEARANCE_FORMULA,
    Aim,
    Guide,
    default_aim,
    is_hidden,
)
from bt_mission.search.material import branch_formulas, material_of
from bt_mission.search.probing import present_in
from bt_mission.search.reference import Reference
from bt_mission.search.search import Search, SearchState, Watch, run_as_it_is
from bt_mission.search.simplify import MOST_RUNS, simplify
from bt_mission.search.space import SearchSpace
from bt_mission.search.strategies import STRATEGIES
from bt_mission.sweeps.base import BaseChanges, BaseScenario, load_base
from bt_mission.sweeps.ranges import Ranges, RangesFile
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
        causes: The search goes on until it has found so many different ones.
    """

    aim: Aim | None = None
    budget: int = 1000
    strategy: str = "optuna"
    seed: int = 0
    simplifying_runs: int = MOST_RUNS
    causes: int = 1


def load_search(
    path: Path, changes: BaseChanges, ranges: RangesFile, aim: Aim | None
) -> BaseScenario:
    """Load what is varied, and check that the ranges fit it.

    Raises:
        InputError: With every error.
    """
    ranges.refuse_others("falsify")
    ranges.check_worlds(path)
    base = load_base(path, changes, ranges.parameters)
    ranges.check_mission(base.mission)
    with ScenarioWorker(base.bundle) as worker:
        worker.refuse_values(base, [one for one in ranges.parameters if one.name != "world"])
    return with_measures(base, ranges, aim)


def with_measures(base: BaseScenario, ranges: RangesFile, aim: Aim | None) -> BaseScenario:
    """Return a base with requirements that only a search has.

    They are the assumptions of the ranges, the distances to branches, and the clearance where a
    collision counts. Obstacles of the base appear where there is room.
    """
    measures = {f"{ASSUMED}{one.text}": one.text for one in ranges.ranges.assume}
    formulas = branch_formulas(material_of(base.mission).branches)
    measures |= {f"{BRANCH}{name}": text for name, text in formulas.items()}
    if aim_of(base, aim) in ("collision", "anything"):
        measures[CLEARANCE] = CLEARANCE_FORMULA
    data: dict[str, Any] = {**base.data}
    if measures:
        data["requirements"] = {**data.get("requirements", {}), **measures}
    moves = ranges.ranges.start is not None or ranges.ranges.worlds
    for key in ("faults", *(["obstacles"] if moves else [])):
        if key in data:
            data[key] = [_with_room(one) for one in data[key]]
    return replace(base, data=data)


def _with_room(written: Any) -> Any:
    """Return a fault of the base, at the nearest free place where it is an obstacle.

    What is varied may bring the robot to where the base has something appear.
    """
    if isinstance(written, str):
        is_spawned = "spawn_" in written and "nearest_free" not in written
        return f"{written} nearest_free" if is_spawned else written
    return {**written, "nearest_free": True} if isinstance(written, dict) else written


def has_requirements(base: BaseScenario) -> bool:
    """Tell whether a base has requirements that are not the search's own."""
    given = [*(one.name for one in base.mission.requirements), *base.data.get("requirements", ())]
    return any(not is_hidden(name) for name in given)


def aim_of(base: BaseScenario, aim: Aim | None) -> Aim:
    """Return what is searched for."""
    return aim or default_aim(has_requirements=has_requirements(base))


class SearchSession:
    """A search on its way: `state` has what it has come to at any time.

    Args:
        base: What is varied.
        ranges: By how much.
        options: How.
        watch: Looks on after each run.
        reference: What breaks it as well is no find.
    """

    def __init__(
        self,
        base: BaseScenario,
        ranges: RangesFile,
        options: SearchOptions,
        watch: Watch,
        reference: Reference | None = None,
    ) -> None:
        self.base = base
        self.aim = aim_of(base, options.aim)
        self.state = SearchState()
        self.as_it_is: ScenarioRow | None = None
        self._ranges = ranges
        self._options = options
        self._watch = watch
        self._reference = reference

    async def run(self, runner: ScenarioRunner) -> None:
        """Search, and make what is found small.

        Raises:
            BtMissionError: When the mission cannot run as it is.
        """
        ranges, options, state = self._ranges.ranges, self._options, self.state
        as_it_is = Candidate(limit=ranges.limit)
        row = await run_as_it_is(self.base, as_it_is, runner)
        self.as_it_is = row
        guide = Guide(self.aim, row)
        state.count(row, guide)
        guide.learn(row)
        search = Search(self.base, runner, guide, state, self._watch, self._reference)
        if failures := guide.failures(row):
            state.add(as_it_is, row, failures[0])
            return
        if not self._watch(state):
            state.is_interrupted = True
            return
        ranges = with_limit(ranges, self.base, row)
        material = await present_in(material_of(self.base.mission), self.base, runner)
        space = SearchSpace(self.base, ranges, self._ranges.parameters, row.virtual_s, material)
        strategy = STRATEGIES[options.strategy](space, options.seed)
        await search.find(strategy, options.budget, options.causes)
        for number in range(len(state.found)):
            if not state.is_interrupted and options.simplifying_runs:
                await simplify(search, space, number, options.simplifying_runs)
        state.found.sort(key=lambda one: one.candidate.size)


def with_limit(ranges: Ranges, base: BaseScenario, row: ScenarioRow) -> Ranges:
    """Return ranges with the time at which runs end, where neither they nor the base say it."""
    if ranges.limit is not None or "limit" in base.data:
        return ranges
    limit = math.ceil(max(LONGER * row.virtual_s, row.virtual_s + AT_LEAST_LONGER_S))
    return ranges.model_copy(update={"limit": float(limit)})
