"""Drawn worlds and missions are sound, repeat, and shrink to the simplest."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import find, given, settings

from bt_mission.mission.check import examine_text
from bt_mission.testing.drawn.draws import Seeded
from bt_mission.testing.drawn.missions import drawn_mission
from bt_mission.testing.drawn.strategies import as_text, missions, worlds
from bt_mission.testing.drawn.worlds import drawn_world
from bt_mission.testing.stages import Stages
from sim.world import load_world


@pytest.mark.parametrize("seed", range(40))
def test_what_is_drawn_from_a_seed_is_sound(seed: int, tmp_path: Path) -> None:
    """And the same each time."""
    draws = Seeded(seed)
    world, mission = as_text(drawn_world(draws)), as_text(drawn_mission(draws))
    again = Seeded(seed)
    assert (world, mission) == (as_text(drawn_world(again)), as_text(drawn_mission(again)))
    path = tmp_path / "world.yaml"
    path.write_text(world)
    load_world(str(path))
    found, faults = examine_text(mission)
    assert found is not None, faults


def test_the_simplest_world_and_mission() -> None:
    """What hypothesis ends up with when nothing matters."""
    world = find(worlds(), lambda _: True)
    assert "boxes: []\ncylinders: []\n" in world
    mission = find(missions(), lambda text: "turn" in text)
    assert len(mission.splitlines()) == 7
    assert mission.splitlines()[-2].startswith("  - turn: {angle: ")


@settings(max_examples=5)
@given(worlds(), missions())
def test_every_one_of_them_runs_to_its_end(tmp_path_factory: Any, world: str, mission: str) -> None:
    """With no goal left behind."""
    stages = Stages(tmp_path_factory.mktemp("drawn"))
    try:
        run = stages.run(mission, world=world)
        assert run.until_done().goals_left_behind == 0
    finally:
        stages.close()
