"""docs/how-to/command-line-tools.md: what it tells people to type is there."""

from __future__ import annotations

import re
import shlex

import pytest

from bt_mission.cli.main import make_parser
from tests.support.project import ROOT
from tests.support.thorough import sample

PAGE = ROOT / "docs" / "how-to" / "command-line-tools.md"
COMMANDS = sorted(set(re.findall(r"^\$ (bt-mission .*)$", PAGE.read_text("utf-8"), re.MULTILINE)))


def test_the_page_shows_every_command() -> None:
    """Else nobody finds it."""
    text = " ".join(COMMANDS)
    for command in ("actions list", "actions info", "actions send", "actions cancel"):
        assert command in text
    for command in ("actions watch", "topics echo", "topics hz", "services call", "tree"):
        assert command in text


@pytest.mark.parametrize("command", sample(COMMANDS, 4))
def test_commands_of_the_page_parse(command: str) -> None:
    """With their options."""
    _, *words = shlex.split(command.partition(" | ")[0])
    options, rest = make_parser().parse_known_args(words)
    assert callable(options.command)
    assert rest == []
