"""What is found is made small: each step is a run that fails in the same way."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest

from bt_mission.base.yaml.document import read_text
from bt_mission.commands.falsify.candidate import Candidate
from bt_mission.commands.falsify.guide import FoundFailure
from bt_mission.commands.falsify.search import Counterexample, Search
from bt_mission.commands.falsify.simplify import rounder_numbers, simplify
from bt_mission.commands.falsify.space import SearchSpace
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario
from bt_mission.scenarios.concrete.ranges import RangesFile
from bt_mission.scenarios.faults.text import parse_fault
from tests.commands.falsify.conftest import Judge, row

BOX = "at 3.25: spawn_box ahead 0.85 left 0.15 size (0.35, 0.35, 0.3)"
OTHERS = (
    "at 2.75: drop scan share 0.75 lasting 1.25",
    "at 7.0: lidar_dead lasting 0.5",
    "at 1.0: spawn_cylinder ahead 1.5 left 0.0 radius 0.1",
    "at 9.25: delay odom 0.35 jitter 0.05 lasting 2.75",
)


def simplified(search: Search, texts: tuple[str, ...], most: int = 150) -> Candidate:
    """Make small what was found with these faults, seed 99 and another speed."""
    faults = tuple(map(parse_fault, texts))
    candidate = Candidate(99, {"speed": 0.237}, faults)
    of_it = row(candidate.concrete(search.base, 1), -0.1)
    search.state.counterexamples = [
        Counterexample(candidate, of_it, FoundFailure("violated", "keeps its distance"))
    ]
    file = RangesFile(read_text("inputs: {speed: 0.1..0.25}"))
    space = SearchSpace(search.base, file.ranges, file.parameters, 20.0)
    asyncio.run(simplify(search, space, 0, most))
    return search.state.counterexamples[0].candidate


def needs(*parts: str) -> Judge:
    """Return a judge for which a scenario breaks with faults that have these parts."""

    def judge(scenario: ConcreteScenario) -> float:
        faults = scenario.data.get("faults", ())
        return -0.1 if all(any(part in text for text in faults) for part in parts) else 0.4

    return judge


def test_what_does_not_matter_goes(search_by: Callable[[Judge], Search]) -> None:
    """Faults, the seed, inputs, arguments; numbers are round; the run ends after the violation."""
    made = simplified(search_by(needs("spawn_box")), (*OTHERS, BOX))
    assert [fault.text for fault in made.faults] == ["at 0.0: spawn_box ahead 0.8"]
    assert (made.seed, made.values) == (None, {})
    assert made.limit == 8.0


def test_what_matters_stays(search_by: Callable[[Judge], Search]) -> None:
    """Two faults that break it together, with the numbers that they need."""
    made = simplified(search_by(needs("spawn_box", "0.35 jitter")), (*OTHERS, BOX))
    assert [fault.name for fault in made.faults] == ["delay", "spawn_box"]
    assert made.faults[0].arguments["by"] == 0.35


def test_an_obstacle_goes_with_its_way(search_by: Callable[[Judge], Search]) -> None:
    """What moves it could not begin without it."""
    texts = (BOX + " name one", "at 4.0: move_box one 1.0 0.0 speed 0.3", OTHERS[1])
    tried: list[list[str]] = []

    def judge(scenario: ConcreteScenario) -> float:
        tried.append(scenario.data.get("faults", []))
        return -0.1 if any("lidar_dead" in text for text in tried[-1]) else 0.4

    made = simplified(search_by(judge), texts)
    assert [fault.name for fault in made.faults] == ["lidar_dead"]
    for faults in tried:
        moves = any("move_box" in text for text in faults)
        assert not moves or any("spawn_box" in text for text in faults)


def test_what_moves_is_simplified(search_by: Callable[[Judge], Search]) -> None:
    """Its speed may be the fault's own; the obstacle stays."""
    texts = ("at 0.0: spawn_box 1.0 name one", "at 0.0: move_box one 1.25 0.35 speed 0.3")
    made = simplified(search_by(needs("spawn_box", "move_box")), texts)
    assert [fault.text for fault in made.faults] == [
        "at 0.0: spawn_box ahead 1.0 name one",
        "at 0.0: move_box box one ahead 0.0",
    ]


def test_an_event_is_simplified(search_by: Callable[[Judge], Search]) -> None:
    """It need not have been true for a time, and nothing else takes its place."""
    made = simplified(
        search_by(needs("lidar_dead")), ('when running("drive") for 1.75 s: lidar_dead lasting 1',)
    )
    assert [fault.text for fault in made.faults] == ['when running("drive"): lidar_dead lasting 1']


def test_the_runs_are_bounded(search_by: Callable[[Judge], Search]) -> None:
    """Then the smallest so far counts."""
    search = search_by(needs("spawn_box"))
    made = simplified(search, (*OTHERS, BOX), most=3)
    assert search.state.simplifying_runs == 3
    assert len(made.faults) < 5


def test_another_failure_does_not_count(search_by: Callable[[Judge], Search]) -> None:
    """Where nothing less fails, all stays as it was found."""
    search = search_by(lambda _: 0.4)
    made = simplified(search, (BOX,))
    assert [fault.text for fault in made.faults] == [parse_fault(BOX).text]
    assert (made.seed, made.values) == (99, {"speed": 0.237})


@pytest.mark.parametrize(
    ("value", "first"), [(3.25, 0.0), (0.237, 0.0), (12.75, 0.0), (-0.55, 0.0), (0.5, 0.0)]
)
def test_rounder_numbers_have_fewer_digits(value: float, first: float) -> None:
    """The roundest comes first, and none is much larger; nothing is rounder than zero."""
    results = rounder_numbers(value)
    assert rounder_numbers(0.0) == []
    assert results[0] == first
    assert value not in results
    assert all(abs(result) <= 1.25 * abs(value) for result in results)
