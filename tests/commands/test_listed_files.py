"""Lists of missions, worlds and robots, and copies; refusals are in transcripts/."""

from __future__ import annotations

import json

import pytest

from bt_mission.base.files import find
from tests.support.command_line import CommandLine


@pytest.mark.parametrize(
    ("kind", "expected"),
    [("missions", "square"), ("worlds", "empty_arena"), ("robots", "burger")],
)
def test_a_list_has_a_line_for_each(cli: CommandLine, kind: str, expected: str) -> None:
    """Name, origin, the first sentence of its description; with `list` or without."""
    lines = cli.lines(kind)
    assert lines == cli.lines(f"{kind} list")
    assert all("  shipped  " in line for line in lines)
    assert any(line.startswith(f"{expected} ") for line in lines)


@pytest.mark.parametrize("command", ["worlds --json", "worlds list --json"])
def test_programs_get_objects(cli: CommandLine, command: str) -> None:
    """One list."""
    worlds = {world["name"]: world for world in json.loads(cli(command))}
    assert worlds["dqn_stage1"] == {
        "name": "dqn_stage1",
        "kind": "world",
        "description": "Four walls and nothing inside, 4.70 m x 4.70 m.",
        "shipped": True,
        "path": str(find("worlds", "dqn_stage1").absolute()),
    }


@pytest.mark.parametrize(
    ("command", "written"),
    [
        ("missions copy square", ["missions/square.yaml"]),
        ("missions copy meanwhile mine.yaml", ["mine.yaml"]),
        ("worlds copy nav_arena halls/mine", ["halls/mine/nav_arena.yaml"]),
        ("robots copy waffle own.yml", ["own.yml"]),
        (
            "missions copy scenarios/square.scenario.yaml",
            ["missions/scenarios/square.scenario.yaml", "missions/square.yaml"],
        ),
        (
            "missions copy fleets/two_wanderers.fleet.yaml",
            ["missions/fleets/two_wanderers.fleet.yaml", "missions/sources/two_metres.yaml"],
        ),
    ],
)
def test_a_copy_is_the_same_file(cli: CommandLine, command: str, written: list[str]) -> None:
    """In the folder of its kind, another folder or a file; with the files that it names."""
    assert cli.lines(command) == [f"{name}: written" for name in written]
    assert sorted(cli.files()) == sorted(written)
