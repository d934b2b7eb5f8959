"""Lists of missions, worlds and robots, and copies; refusals are in transcripts/missions.txt."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bt_mission.core.files import find
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


def test_a_copy_replaces_the_shipped_file(cli: CommandLine) -> None:
    """By its name, in this folder; it is valid there, and is not copied onto itself."""
    cli("missions copy square")
    assert cli("check square").startswith("missions/square.yaml: mission 'square' is valid")
    assert "square" in cli.lines("missions")[0]
    error = cli.refused("missions copy square --force")
    assert "missions/square.yaml is the same file" in error


def test_a_file_that_exists_is_kept(cli: CommandLine) -> None:
    """Each of them, before anything is written; unless --force is given."""
    cli.write("missions/square.yaml", "mine\n")
    command = "missions copy scenarios/square.scenario.yaml"
    expected = "missions/square.yaml exists; give another name, or --force to overwrite it"
    assert cli.refused(command) == f"{expected} [BT-1103]\n"
    assert not Path("missions/scenarios").exists()
    cli(f"{command} --force")
    assert "mission: square" in Path("missions/square.yaml").read_text("utf-8")


def test_a_copy_does_not_take_the_place_of_a_file_that_it_names(cli: CommandLine) -> None:
    """Both would be written to one file, and one of them lost."""
    cli.write("a.yaml", "mission: a\ninclude: [b.yaml]\ntree: {wait: 1}\n")
    cli.write("b.yaml", "trees: {}\n")
    error = cli.refused("missions copy a.yaml new/b.yaml")
    assert "a.yaml names b.yaml, which is also copied" in error
    assert not Path("new").exists()
