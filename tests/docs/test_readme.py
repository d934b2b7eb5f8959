"""The commands of README.md can be typed as they stand there."""

from __future__ import annotations

import re
import shlex

import pytest

from bt_mission.cli.argument_types import FileType
from bt_mission.cli.main import make_parser
from bt_mission.core.files import look_for
from tests.support.project import ROOT

BLOCKS = re.findall(
    r"^```\w*\n(.*?)^```", (ROOT / "README.md").read_text("utf-8"), re.MULTILINE | re.DOTALL
)
SHELL = [
    [line for line in block.splitlines() if line.startswith("bt-mission ")] for block in BLOCKS
]


@pytest.mark.parametrize("lines", [*filter(None, SHELL)])
def test_what_a_command_reads_is_there(lines: list[str]) -> None:
    """In the checkout, by its name, or made by a line above."""
    made: set[str] = set()
    parser = make_parser()
    for line in lines:
        words = shlex.split(line.partition(" | ")[0].partition(" > ")[0], comments=True)[1:]
        options = parser.parse_args(words)
        for option in options.parser.options:
            given = getattr(options, option.attribute, None) or []
            if not isinstance(option.type, FileType):
                continue
            for path in given if isinstance(given, list) else [given]:
                if option.type.role != "input":
                    made.add(str(path))
                else:
                    is_there = str(path) in made or look_for("missions", path) or "*" in path.name
                    assert is_there or (ROOT / path).is_file(), line
