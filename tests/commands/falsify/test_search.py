"""Searches: they repeat, keep to their budget, and take what is found first in their own order."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.yaml.document import read_text
from bt_mission.commands.falsify.reference import Reference, load_reference
from bt_mission.commands.falsify.search import Search
from bt_mission.commands.falsify.session import SearchOptions, SearchSession, aim_of, load_search
from bt_mission.commands.falsify.space import SearchSpace
from bt_mission.commands.falsify.strategies import OptunaStrategy, RandomStrategy
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, BaseScenario
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario
from bt_mission.scenarios.concrete.ranges import RangesFile
from bt_mission.scenarios.concrete.row import row_of_error
from tests.commands.falsify.conftest import MISSION, Judge, MadeUpRunner

MakeSearch = Callable[[Judge], Search]


def space_of(base: BaseScenario) -> SearchSpace:
    """Return all that may be tried where no file says what."""
    return SearchSpace(base, RangesFile().ranges, (), 20.0)


def carry_out(search: Search, strategy: type[Any], budget: int, seed: int = 0) -> None:
    """Search by a strategy."""
    asyncio.run(search.find(strategy(space_of(search.base), seed), budget))


def far(_: ConcreteScenario) -> float:
    """Judge that nothing comes near."""
    return 0.5


def test_the_budget_is_kept(search_by: MakeSearch) -> None:
    """Also one that is no multiple of a batch; the smallest margin is known."""
    search = search_by(far)
    carry_out(search, RandomStrategy, 37)
    assert (search.state.runs, search.runner.count) == (37, 37)  # type: ignore[attr-defined]
    assert search.state.counterexamples == []
    assert search.state.smallest == (0.5, "keeps its distance")


def test_the_first_in_the_order_of_asking_is_found(search_by: MakeSearch) -> None:
    """Whatever ends first: here every scenario from the sixth on is one."""
    search = search_by(lambda scenario: -0.1 if scenario.number >= 5 else 0.5)
    carry_out(search, RandomStrategy, 100)
    (counterexample,) = search.state.counterexamples
    assert counterexample.row.number == 5
    assert search.state.runs == 6


@pytest.mark.parametrize("strategy", [OptunaStrategy, RandomStrategy])
def test_a_search_repeats(search_by: MakeSearch, strategy: type[Any]) -> None:
    """Its candidates follow from its seed and what runs came to."""

    def asked(seed: int) -> list[str]:
        ids: list[str] = []

        def judge(scenario: ConcreteScenario) -> float:
            ids.append(scenario.id)
            return 1 - scenario.data["seed"] / 1000

        carry_out(search_by(judge), strategy, 20, seed)
        return ids

    first = asked(3)
    assert len(set(first)) > 15
    assert asked(3) == first
    assert asked(4) != first


@pytest.mark.thorough
def test_a_guided_search_comes_nearer(search_by: MakeSearch) -> None:
    """Where the margin falls with the seed, seeds grow."""
    seeds: list[int] = []

    def judge(scenario: ConcreteScenario) -> float:
        seeds.append(scenario.data["seed"])
        return 1.001 - scenario.data["seed"] / 1000

    search = search_by(judge)
    ranges = RangesFile(read_text("obstacles: {most: 0}\nfaults: {most: 0}")).ranges
    made = OptunaStrategy(SearchSpace(search.base, ranges, (), 20.0), 0)
    asyncio.run(search.find(made, 160))
    assert sum(seeds[-32:]) / 32 > 800


def test_who_looks_on_can_end_it(search_by: MakeSearch) -> None:
    """What was found so far stays."""
    search = search_by(far)
    stopping = Search(
        search.base, search.runner, search.guide, search.state, lambda state: state.runs < 3
    )
    carry_out(stopping, RandomStrategy, 100)
    assert search.state.is_interrupted
    assert search.state.runs == 3


def session(base: BaseScenario, judge: Judge, **options: Any) -> SearchSession:
    """Carry a whole search out."""
    made = SearchSession(base, RangesFile(), SearchOptions(**options), lambda _: True)
    asyncio.run(made.run(MadeUpRunner(judge)))
    return made


def test_a_mission_that_breaks_as_it_is(base: BaseScenario) -> None:
    """One run is enough, and nothing of it is varied."""
    state = session(base, lambda _: -0.1).state
    assert state.runs == 1
    (counterexample,) = state.counterexamples
    assert counterexample.candidate.faults == ()


def test_what_is_found_is_made_small(base: BaseScenario) -> None:
    """Here it needs a box that appears at 4 s or later, and nothing else."""

    def judge(scenario: ConcreteScenario) -> float:
        times = [
            float(text.split()[1][:-1])
            for text in scenario.data.get("faults", ())
            if re.match(r"at \S+: spawn_box", text)
        ]
        return -0.1 if max(times, default=0) >= 4 else 0.5

    (counterexample,) = session(base, judge).state.counterexamples
    (fault,) = counterexample.candidate.faults
    assert fault.name == "spawn_box"
    assert counterexample.candidate.seed is None
    assert len(f"{fault.begins.time_s:g}".rstrip("0")) == 1  # type: ignore[union-attr]


def test_a_mission_that_cannot_run(base: BaseScenario) -> None:
    """Is told with its reason."""

    class Broken(MadeUpRunner):
        async def rows(self, scenarios: Any) -> Any:
            for scenario in scenarios:
                yield row_of_error(scenario, "the leaf is gone")

    made = SearchSession(base, RangesFile(), SearchOptions(), lambda _: True)
    with pytest.raises(BtMissionError, match="the unchanged mission cannot run: the leaf is gone"):
        asyncio.run(made.run(Broken(far)))


def test_what_is_searched_for(base: BaseScenario) -> None:
    """A violated requirement where there are any that are not the search's own."""
    plain = replace(base, mission=replace(base.mission, requirements=()))
    assumed = replace(plain, data={**plain.data, "requirements": {"assumed: x": "always true"}})
    aims = [aim_of(searched, None) for searched in (base, plain, assumed)]
    assert aims == ["violated", "anything", "anything"]
    assert aim_of(base, "collision") == "collision"


# ---- a reference: what breaks it as well is no find --------------------------------------------


RANGES = RangesFile(read_text("assume: [always speed < 0.3]"))


def searched(base: BaseScenario, mission: Judge, good: Judge, budget: int = 60) -> SearchSession:
    """Search, where functions say what runs of the mission and of the reference come to."""
    session = SearchSession(
        base,
        RANGES,
        SearchOptions("violated", budget, 2, simplifying_runs=20),
        lambda _: True,
        Reference(base, MadeUpRunner(good)),
    )
    asyncio.run(session.run(MadeUpRunner(mission)))
    return session


def has(name: str) -> Judge:
    """Return a judge for which a scenario with a fault of this name breaks."""
    return lambda scenario: (
        -0.1 if any(name in text for text in scenario.data.get("faults", ())) else 0.5
    )


def either(scenario: ConcreteScenario) -> float:
    """Break with a box, and with a cylinder."""
    return min(
        has("at 0.0: spawn")(scenario), has("spawn_box")(scenario), has("spawn_cylinder")(scenario)
    )


def test_what_breaks_the_reference_does_not_count(base: BaseScenario) -> None:
    """Not as a find, nor as a step that makes a find small."""
    state = searched(base, either, has("spawn_box")).state
    assert state.unfair > 0
    (counterexample,) = state.counterexamples
    assert {fault.name for fault in counterexample.candidate.faults} == {"spawn_cylinder"}


def test_a_search_whose_finds_are_all_unfair_finds_nothing(base: BaseScenario) -> None:
    """However many there are."""
    state = searched(base, either, either).state
    assert state.counterexamples == []
    assert state.unfair > 10
    assert state.runs == 60


def test_it_runs_in_the_scenario_of_the_mission(tmp_path: Path) -> None:
    """The same place, faults, inputs, requirements and assumptions, and its own requirements."""
    (tmp_path / "short.yaml").write_text(MISSION)
    good = MISSION.replace(
        "keeps its distance: always clearance > 0.1", "is slow: always speed < 1"
    )
    (tmp_path / "good.yaml").write_text(good.replace("mission: short", "mission: good"))
    scenario = tmp_path / "it.scenario.yaml"
    scenario.write_text(
        "scenario: it\nmission: short.yaml\nworld: dqn_stage1\nstart: {x: 0.5}\n"
        "inputs: {speed: 0.15}\nfaults: ['at 2.0: drop scan lasting 1']\n"
    )
    base = load_search(scenario, BaseChanges(), RANGES, None)
    made = load_reference(tmp_path / "good.yaml", base, RANGES)
    data = made.concrete({"speed": 0.1}).data
    assert data["mission"] == "good.yaml"
    assert (data["start"], data["world"]) == ({"x": 0.5}, "dqn_stage1")
    assert data["inputs"] == {"speed": 0.1}
    assert data["faults"] == ["at 2.0: drop scan lasting 1"]
    assert set(data["requirements"]) == {"keeps its distance", "assumed: always speed < 0.3"}
    assert [requirement.name for requirement in made.mission.requirements] == ["is slow"]


def test_a_reference_that_does_not_fit(tmp_path: Path, base: BaseScenario) -> None:
    """Inputs that it does not have, and nodes that a requirement names."""
    other = MISSION.replace("speed: 0.2, ", "").replace("$speed", "0.2")
    (tmp_path / "good.yaml").write_text(other)
    ranges = RangesFile(read_text("inputs: {speed: 0.1..0.2}", "ranges.yaml"))
    with pytest.raises(InputError, match="unknown input 'speed'"):
        load_reference(tmp_path / "good.yaml", base, ranges)
    (tmp_path / "good.yaml").write_text(MISSION.replace("name: drive", "name: go"))
    data = {**base.data, "requirements": {"it ends": 'eventually succeeded("drive")'}}
    with pytest.raises(BtMissionError, match="does not fit the scenario: unknown node: 'drive'"):
        load_reference(tmp_path / "good.yaml", replace(base, data=data), RANGES)
