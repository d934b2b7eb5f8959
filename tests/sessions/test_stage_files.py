"""What a recording keeps of the world of a stage."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.core.files import names
from bt_mission.core.yaml.document import read_text
from bt_mission.sessions.load import load
from bt_mission.sessions.stage_files import StageFiles
from bt_mission.sessions.stage_robot import FleetRobot, StageOptions
from sim.world.loader import load_world

MEMBERS = [FleetRobot("", load("mission: m\ntree: {wait: 1}\n"))]


@pytest.mark.parametrize("name", names("worlds"))
def test_a_world_that_stands_in_no_file_is_read_back_as_it_was(name: str) -> None:
    """Such as one of a scenario: in the form of a file."""
    world = load_world(name)
    result = StageFiles.find(MEMBERS, StageOptions(world=world))
    assert result.world is world
    (text,) = (
        first for file, first in result.contents.items() if file == f"worlds/{world.name}.yaml"
    )
    assert load_world(read_text(text.decode(), "copy")) == world


def test_a_world_of_a_file_is_kept_with_its_comments() -> None:
    """As it stands there."""
    path = Path(__file__).parents[2] / "worlds" / "empty_arena.yaml"
    result = StageFiles.find(MEMBERS, StageOptions(world=path))
    assert result.contents["worlds/empty_arena.yaml"] == path.read_bytes()
