"""``bt-mission schema``: the JSON Schema of mission files, for editors."""

from __future__ import annotations

import argparse
import json
from typing import Any

from bt_mission.cli.exits import SUCCESS


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "schema",
        help="print the JSON Schema of mission files, for editors",
        description="Prints the JSON Schema of mission files. An editor with a YAML language "
        "server completes and checks missions by it: put it into a file, and say so in the first "
        "line of a mission: '# yaml-language-server: $schema=mission.schema.json'.",
    )
    parser.set_defaults(command=print_schema)


def print_schema(_options: argparse.Namespace) -> int:
    """Print it."""
    from bt_mission.language.schema import mission_schema

    print(json.dumps(mission_schema(), indent=2))
    return SUCCESS
