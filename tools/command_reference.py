"""The help of every command as Markdown, for the page of commands in the documentation site."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator

from bt_mission.cli.main import make_parser
from bt_mission.cli.subparsers import load_commands

WIDTH = 88
"""Columns of the help texts."""


def command_reference() -> str:
    """Return a section for each command, and for those below it."""
    os.environ["COLUMNS"] = str(WIDTH)  # argparse wraps by it
    return "".join(_sections(load_commands(make_parser())))


def _sections(action: argparse.Action) -> Iterator[str]:
    for parser in (action.choices or {}).values():
        yield f"\n## {parser.prog}\n\n```text\n{parser.format_help()}```\n"
        for inner in parser._actions:  # noqa: SLF001 - argparse has no public way to its arguments
            if isinstance(inner.choices, dict):
                yield from _sections(inner)
