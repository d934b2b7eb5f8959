"""A search: it repeats, keeps to its budget, and takes what is found first in its own order."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from bt_mission.core.errors import BtMissionError
from bt_mission.core.yaml.document import read_text
from bt_mission.search.search import Search
from bt_mission.search.session import SearchOptions, SearchSession, aim_of
from bt_mission.search.space import SearchSpace
from bt_mission.search.strategies import STRATEGIES
from bt_mission.sweeps.base import BaseScenario
from bt_mission.sweeps.concrete import ConcreteScenario
from bt_mission.sweeps.ranges import RangesFile
from bt_mission.sweeps.row import row_of_error
from tests.search.conftest import Judge, MadeUpRunner

MakeSearch = Callable[[Judge], Search]


def space_of(base: BaseScenario) -> SearchSpace:
    """Return all that may be tried where no file says what."""
    return SearchSpace(base, RangesFile().ranges, (), 20.0)


def carry_out(search: Search, strategy: str, budget: int, seed: int = 0) -> None:
    """Search by a strategy."""
    made = STRATEGIES[strategy](space_of(search.base), seed)
    asyncio.run(search.find(made, budget))


def far(_: ConcreteScenario) -> float:
    """Judge that nothing comes near."""
    return 0.5


def test_the_budget_is_kept(search_by: MakeSearch) -> None:
    """Also one that is no multiple of a batch; the smallest margin is known."""
    search = search_by(far)
    carry_out(search, "random", 37)
    assert (search.state.runs, search.runner.count) == (37, 37)  # type: ignore[attr-defined]
    assert search.state.counterexamples == []
    assert search.state.smallest == (0.5, "keeps its distance")


def test_the_first_in_the_order_of_asking_is_found(search_by: MakeSearch) -> None:
    """Whatever ends first: here every scenario from the sixth on is one."""
    search = search_by(lambda scenario: -0.1 if scenario.number >= 5 else 0.5)
    carry_out(search, "random", 100)
    (counterexample,) = search.state.counterexamples
    assert counterexample.row.number == 5
    assert search.state.runs == 6


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_a_search_repeats(search_by: MakeSearch, strategy: str) -> None:
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


def test_a_guided_search_comes_nearer(search_by: MakeSearch) -> None:
    """Where the margin falls with the seed, seeds grow."""
    seeds: list[int] = []

    def judge(scenario: ConcreteScenario) -> float:
        seeds.append(scenario.data["seed"])
        return 1.001 - scenario.data["seed"] / 1000

    search = search_by(judge)
    ranges = RangesFile(read_text("obstacles: {most: 0}\nfaults: {most: 0}")).ranges
    made = STRATEGIES["optuna"](SearchSpace(search.base, ranges, (), 20.0), 0)
    asyncio.run(search.find(made, 160))
    assert sum(seeds[-32:]) / 32 > 800


def test_who_looks_on_can_end_it(search_by: MakeSearch) -> None:
    """What was found so far stays."""
    search = search_by(far)
    stopping = Search(
        search.base, search.runner, search.guide, search.state, lambda state: state.runs < 3
    )
    carry_out(stopping, "random", 100)
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
