"""A reference: what breaks it as well is no find."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from pathlib import Path

import pytest

from bt_mission.core.diagnostics import InputError
from bt_mission.core.errors import BtMissionError
from bt_mission.core.yaml.document import read_text
from bt_mission.search.reference import Reference, load_reference
from bt_mission.search.session import SearchOptions, SearchSession, load_search
from bt_mission.sweeps.base import BaseChanges, BaseScenario
from bt_mission.sweeps.concrete import ConcreteScenario
from bt_mission.sweeps.ranges import RangesFile
from tests.search.conftest import MISSION, Judge, MadeUpRunner

RANGES = RangesFile(read_text("assume: [always speed < 0.3]"))


def searched(base: BaseScenario, mission: Judge, good: Judge, budget: int = 60) -> SearchSession:
    """Search, where functions say what runs of the mission and of the reference come to."""
    session = SearchSession(
        base,
        RANGES,
        SearchOptions("violated", budget, "random", 1, simplifying_runs=20),
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
    assert (data["start"], data["world"], data["inputs"]) == (
        {"x": 0.5},
        "dqn_stage1",
        {"speed": 0.1},
    )
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
