"""A search from its files to its end."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from bt_mission.base.errors import BtMissionError
from bt_mission.commands.falsify.candidate import Candidate
from bt_mission.commands.falsify.guide import (
    ASSUMED,
    BRANCH,
    CLEARANCE,
    CLEARANCE_FORMULA,
    Aim,
    Guide,
    is_hidden,
)
from bt_mission.commands.falsify.material import branch_formulas, material_of, present_in
from bt_mission.commands.falsify.reference import Reference
from bt_mission.commands.falsify.search import Search, SearchState, Watch
from bt_mission.commands.falsify.simplify import MOST_RUNS, simplify
from bt_mission.commands.falsify.space import SearchSpace
from bt_mission.commands.falsify.strategies import OptunaStrategy
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, BaseScenario, load_base
from bt_mission.scenarios.concrete.ranges import RangesFile
from bt_mission.scenarios.concrete.row import ScenarioRow
from bt_mission.scenarios.concrete.worker import ScenarioRunner, ScenarioWorker

LONGER = 3.0
"""A run counts as endless after this many times the time of the mission as it is."""

AT_LEAST_LONGER_S = 30.0


@dataclass(frozen=True)
class SearchOptions:
    """The options of a search.

    Attributes:
        aim: None is a violated requirement where there are any, and else anything.
        budget: The most runs, without those that minimize counterexamples.
        seed: The search follows from it.
        simplifying_runs: The most runs that minimize a counterexample; 0 does not minimize.
        causes: The search continues until this number of different causes.
    """

    aim: Aim | None = None
    budget: int = 200
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
        worker.refuse_values(
            base, [parameter for parameter in ranges.parameters if parameter.name != "world"]
        )
    return _with_measures(base, ranges, aim)


def _with_measures(base: BaseScenario, ranges: RangesFile, aim: Aim | None) -> BaseScenario:
    """Return a base with requirements that only a search has.

    They are the assumptions of the ranges, the distances to branches, and the clearance where a
    collision counts. They emit no events, so that a run has the trace of its scenario file.
    Obstacles of the base appear where there is room.
    """
    measures = {f"{ASSUMED}{formula.text}": formula.text for formula in ranges.ranges.assume}
    formulas = branch_formulas(material_of(base.mission).branches)
    measures |= {f"{BRANCH}{name}": text for name, text in formulas.items()}
    if aim_of(base, aim) in ("collision", "anything"):
        measures[CLEARANCE] = CLEARANCE_FORMULA
    data: dict[str, Any] = {**base.data}
    if measures:
        data["requirements"] = {
            **data.get("requirements", {}),
            **{
                name: {"formula": text, "on_violation": "measure"}
                for name, text in measures.items()
            },
        }
    moves = ranges.ranges.start is not None or ranges.ranges.worlds
    for key in ("faults", *(["obstacles"] if moves else [])):
        if key in data:
            data[key] = [_with_room(formula) for formula in data[key]]
    return replace(base, data=data)


def _with_room(written: Any) -> Any:
    """Return a fault of the base; an obstacle is put at the nearest free place.

    The variation may move the robot to the place of an obstacle of the base.
    """
    if isinstance(written, str):
        is_spawned = "spawn_" in written and "nearest_free" not in written
        return f"{written} nearest_free" if is_spawned else written
    return {**written, "nearest_free": True} if isinstance(written, dict) else written


def aim_of(base: BaseScenario, aim: Aim | None) -> Aim:
    """Return what is searched for: by default a violated requirement, if the base has any."""
    given = [
        *(requirement.name for requirement in base.mission.requirements),
        *base.data.get("requirements", ()),
    ]
    default: Aim = "anything" if all(map(is_hidden, given)) else "violated"
    return aim or default


@dataclass
class SearchSession:
    """A search for counterexamples of a mission.

    Attributes:
        base: The scenario that is varied.
        ranges: The ranges of the variation.
        options: The options of the search.
        watch: Called after each run.
        reference: A mission that a counterexample must not break.
        state: The progress, at any time.
        as_it_is: The run of the mission without changes.
    """

    base: BaseScenario
    ranges: RangesFile
    options: SearchOptions
    watch: Watch
    reference: Reference | None = None
    state: SearchState = field(default_factory=SearchState)
    as_it_is: ScenarioRow | None = None

    @property
    def aim(self) -> Aim:
        """The target of the search."""
        return aim_of(self.base, self.options.aim)

    async def run(self, runner: ScenarioRunner) -> None:
        """Search, and minimize the counterexamples.

        Raises:
            BtMissionError: The mission cannot run as it is.
        """
        options, state = self.options, self.state
        candidate, row = await self._run_as_it_is(runner)
        self.as_it_is = row
        guide = Guide(self.aim, row)
        state.count(row, guide)
        guide.learn(row)
        search = Search(self.base, runner, guide, state, self.watch, self.reference)
        if failures := guide.failures(row):
            state.add(candidate, row, failures[0])
            return
        if not self.watch(state):
            state.is_interrupted = True
            return
        space = await self._space(row, runner)
        await search.find(OptunaStrategy(space, options.seed), options.budget, options.causes)
        for number in range(len(state.counterexamples)):
            if not state.is_interrupted and options.simplifying_runs:
                await simplify(search, space, number, options.simplifying_runs)
        state.counterexamples.sort(key=lambda counterexample: counterexample.candidate.size)

    async def _run_as_it_is(self, runner: ScenarioRunner) -> tuple[Candidate, ScenarioRow]:
        """Run the mission with nothing varied.

        Raises:
            BtMissionError: When it cannot run.
        """
        candidate = Candidate(limit=self.ranges.ranges.limit)
        async for row in runner.rows([candidate.concrete(self.base, 0)]):
            if row.is_error:
                raise BtMissionError(
                    f"{self.base.path}: the unchanged mission cannot run: {row.reason}",
                    code="BT-711",
                )
            return candidate, row
        raise BtMissionError(
            f"{self.base.path}: the run of the unchanged mission gave no result", code="BT-711"
        )

    async def _space(self, as_it_is: ScenarioRow, runner: ScenarioRunner) -> SearchSpace:
        """Return the space of candidates.

        Without an end of runs in ranges and base, it is some time after that of the mission as it
        is.
        """
        ranges, usual_s = self.ranges.ranges, as_it_is.virtual_s
        if ranges.limit is None and "limit" not in self.base.data:
            limit = math.ceil(max(LONGER * usual_s, usual_s + AT_LEAST_LONGER_S))
            ranges = ranges.model_copy(update={"limit": float(limit)})
        material = await present_in(material_of(self.base.mission), self.base, runner)
        return SearchSpace(self.base, ranges, self.ranges.parameters, usual_s, material)
