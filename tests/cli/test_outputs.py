"""Outputs that would destroy something are refused before a run; see transcripts/outputs.txt."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from bt_mission.cli.argument_types import FileType
from bt_mission.cli.main import make_parser
from bt_mission.cli.subparsers import load_commands
from tests.support.command_cases import cases
from tests.support.command_line import CommandLine

OLD = "the only copy"
MISSION = "mission: m\nworld: empty_arena\ntree:\n  wait: 0.1\n"


@pytest.mark.parametrize(
    ("command", "name"),
    [
        ("run m.yaml --json --record", "run.mcap"),
        ("run m.yaml --json --report", "run.html"),
        ("run m.yaml --json --trace", "run.trace"),
        ("tree m.yaml -o", "tree.dot"),
        ("report given.mcap -o", "page.html"),
        ("report given.mcap", "given.html"),
        *cases("OUTPUTS"),
    ],
)
def test_a_file_that_exists_is_kept(cli: CommandLine, command: str, name: str) -> None:
    """As ros2 bag record does; `--force` overwrites it."""
    cli.write("m.yaml", MISSION)
    if "given.mcap" in command:
        cli("run m.yaml --json --record given.mcap")
    cli.write(name, OLD)
    command += f" {name}" if command.endswith(("-o", "--record", "--report", "--trace")) else ""
    error = cli.refused(command)
    hint = "give another name, or --force to overwrite it"
    assert error.endswith(f"{name} exists; {hint} [BT-1103]\n")
    assert Path(name).read_text("utf-8") == OLD
    cli(f"{command} --force")
    assert Path(name).read_bytes() != OLD.encode()


@pytest.mark.parametrize("link", [os.symlink, os.link])
def test_a_link_to_an_input_is_that_input(cli: CommandLine, link: object) -> None:
    """Whatever the name of the link is."""
    cli.write("m.yaml", MISSION)
    assert callable(link)
    link("m.yaml", "link.jsonl")
    error = cli.refused("run m.yaml --trace link.jsonl --force")
    assert "--trace m.yaml: is the file that FILE names" in error
    assert Path("m.yaml").read_text("utf-8") == MISSION


def test_a_device_takes_several_outputs(cli: CommandLine) -> None:
    """It is not a file: it is not overwritten, and keeps its own name."""
    cli.write("m.yaml", MISSION)
    cli("run m.yaml --json --trace /dev/null --record /dev/null")
    cli("tree m.yaml --format dot -o /dev/null")


def test_options_with_files_declare_what_they_are() -> None:
    """Otherwise the rule does not know them; folders are not files."""
    undeclared = [
        f"{name} {option.attribute}"
        for name, parser in load_commands(make_parser()).choices.items()
        if any(
            isinstance(each.type, FileType) and "output" in each.type.role
            for each in parser.options
        )
        for option in parser.options
        if option.type is Path and option.metavar not in ("FOLDER", "DIR")
    ]
    assert undeclared == ["run images", *cases("FOLDERS_OF_OPTIONS")]
