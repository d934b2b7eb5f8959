"""A short mission, and a runner that makes rows up instead of simulating."""

from __future__ import annotations

from collections.abc import AsyncGenerator, Callable, Iterable
from pathlib import Path

import pytest

from bt_mission.base.verdicts import Verdict
from bt_mission.commands.falsify.guide import Guide
from bt_mission.commands.falsify.search import Search, SearchState
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, BaseScenario, load_base
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario
from bt_mission.scenarios.concrete.row import RequirementMargin, ScenarioRow

MISSION = """\
mission: short
world: empty_arena
seed: 5
inputs: {speed: 0.2, rounds: 1}
tree:
  explore_forward: {fwd_velocity: $speed, stopping_distance: 0.4}
  name: drive
  timeout: 15
requirements:
  keeps its distance: always clearance > 0.1
"""

Judge = Callable[[ConcreteScenario], float]
"""Gives the margin of a scenario."""


class MadeUpRunner:
    """Gives each scenario the margin that a function says; the last scenario ends first."""

    def __init__(self, judge: Judge) -> None:
        self._judge = judge
        self.count = 0

    async def rows(
        self, scenarios: Iterable[ConcreteScenario]
    ) -> AsyncGenerator[ScenarioRow, None]:
        for scenario in reversed(list(scenarios)):
            self.count += 1
            yield row(scenario, self._judge(scenario))


def row(scenario: ConcreteScenario, margin: float) -> ScenarioRow:
    """Return the row of a run with one requirement."""
    verdict: Verdict = "violated" if margin < 0 else "holds"
    return ScenarioRow(
        scenario.id,
        scenario.number,
        seed=int(scenario.data["seed"]),
        outcome="success",
        virtual_s=20.0,
        requirements={"keeps its distance": RequirementMargin(verdict, margin, "m", 7.3)},
    )


@pytest.fixture
def base(tmp_path: Path) -> BaseScenario:
    """Load the short mission."""
    path = tmp_path / "short.yaml"
    path.write_text(MISSION)
    return load_base(path, BaseChanges())


@pytest.fixture
def search_by(base: BaseScenario) -> Callable[[Judge], Search]:
    """Make a search whose runs come to what a function says; usual margins are 1 m."""

    def made(judge: Judge) -> Search:
        usual = row(base.concrete({}), 1.0)
        guide = Guide("violated", usual)
        return Search(base, MadeUpRunner(judge), guide, SearchState(), lambda _: True)

    return made
