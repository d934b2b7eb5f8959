"""``bt-mission schema``: the JSON Schema of a kind of file, for editors."""

from __future__ import annotations

import argparse
import json

from bt_mission.base.commands import all_rows, brought_kinds, loaded
from bt_mission.base.file_kinds import FORMATS
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.parser import Command, Option

SCHEMAS = {
    name: kind.schema
    for name, kind in {**FORMATS, **brought_kinds(all_rows())}.items()
    if kind.schema
}
"""The function that returns the schema of each kind of file."""


def print_schema(options: argparse.Namespace) -> int:
    """Print it."""
    print(json.dumps(loaded(SCHEMAS[options.of])(), indent=2))
    return SUCCESS


COMMANDS = {
    "schema": Command(
        print_schema,
        "Prints the JSON Schema of a kind of file. An editor with a YAML language server uses it "
        "to complete and check missions: save it to a file, and name that file in the first line "
        "of a mission: '# yaml-language-server: $schema=mission.schema.json'.",
        (
            Option(
                "of",
                "kind of file (default: mission)",
                nargs="?",
                choices=tuple(SCHEMAS),
                default="mission",
            ),
        ),
    ),
}
