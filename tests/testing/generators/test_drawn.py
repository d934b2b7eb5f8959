"""Drawn worlds and missions are sound, repeat, and shrink to the simplest."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import find, given, settings

from bt_mission.scenarios.draws import SeededDraws
from bt_mission.scenarios.faults import FAULTS
from bt_mission.scenarios.faults.drawing import drawn_faults
from bt_mission.scenarios.run import run_scenario
from bt_mission.sessions.check import examine
from bt_mission.testing.generators.missions import drawn_mission
from bt_mission.testing.generators.scenarios import DrawnScenario, as_text, drawn_scenario
from bt_mission.testing.generators.strategies import fault_schedules, missions, scenarios, worlds
from bt_mission.testing.generators.worlds import drawn_world
from bt_mission.testing.stages import Stages
from sim.world.loader import load_world
from tests.support.thorough import sample


@pytest.mark.parametrize("seed", sample(range(40), 4))
def test_what_is_drawn_from_a_seed_is_sound(seed: int, tmp_path: Path) -> None:
    """And the same each time."""
    draws = SeededDraws(seed)
    world, mission = as_text(drawn_world(draws)), as_text(drawn_mission(draws))
    again = SeededDraws(seed)
    assert (world, mission) == (as_text(drawn_world(again)), as_text(drawn_mission(again)))
    path = tmp_path / "world.yaml"
    path.write_text(world)
    load_world(str(path))
    diagnostics, faults = examine(mission)
    assert diagnostics is not None, faults


@pytest.mark.thorough
def test_the_simplest_world_and_mission() -> None:
    """What hypothesis ends up with when nothing matters."""
    world = find(worlds(), lambda _: True)
    assert "boxes: []\ncylinders: []\n" in world
    mission = find(missions(), lambda text: "turn" in text)
    assert len(mission.splitlines()) == 7
    assert mission.splitlines()[-2].startswith("  - turn: {angle: ")


@settings(max_examples=5)
@given(scenarios())
def test_every_scenario_runs_to_its_end(tmp_path_factory: Any, scenario: DrawnScenario) -> None:
    """Whatever is broken on the way, a mission comes to an end."""
    stages = Stages(tmp_path_factory.mktemp("drawn"))
    try:
        run = scenario.on(stages)
        run.until_done()
        assert run.is_done
    finally:
        stages.close()


def test_a_scenario_looks_like_the_file_that_repeats_it(tmp_path: Path) -> None:
    """To be pasted as it is; the same trace comes out."""
    scenario = next(
        result
        for seed in range(99)
        if len((result := drawn_scenario(SeededDraws(seed))).faults) > 2
    )
    path = tmp_path / "drawn.yaml"
    path.write_text(repr(scenario), encoding="utf-8")
    stages = Stages(tmp_path)
    run = scenario.on(stages)
    run.until_done()
    stages.close()
    assert run_scenario(path).report.trace_sha256 == run.stage.trace.sha256


def test_the_simplest_schedule_that_matters() -> None:
    """One fault, not five."""
    (fault,) = find(
        fault_schedules(),
        lambda faults: any(planned.name == "freeze" for planned in faults),
    )
    assert repr(fault) == "<at 0.25: freeze scan lasting 0.25 may_not_happen>"


DRIVES = """\
mission: drives
world: empty_arena
tree:
  sequence:
    - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.3}
      name: drive
      cancel_when: current_distance_travelled > 0.6
      on_cancel: success
      timeout: 8
    - turn: {angle: 30}
      timeout: 8
"""


@pytest.mark.parametrize("name", sample(FAULTS, every=18))
def test_a_drawn_fault_can_begin(name: str, tmp_path: Path) -> None:
    """Whatever it breaks, the mission ends, and no goal is left that nobody names."""
    draws = SeededDraws(name)
    faults = next(result for _ in range(99) if (result := drawn_faults(draws, [name], ["drive"])))
    stages = Stages(tmp_path)
    try:
        run = stages.run(DRIVES)
        stages.plan(run, *faults[:2])
        try:
            run.until_done()
        except RuntimeError as error:
            assert str(error) == "made by a fault"  # noqa: PT017 - only some of them raise
        assert run.is_done or name == "raise_in_callback"
    finally:
        stages.close()
