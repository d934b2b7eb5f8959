"""``bt-mission explain``: what the code of an error means, with an example and a cure."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from itertools import groupby
from textwrap import fill, indent

from bt_mission.base.diagnostics import quoted
from bt_mission.base.error_catalogue import (
    CatalogueEntry,
    catalogue,
    entries_about,
    entry_of,
    looks_like_code,
    shown,
)
from bt_mission.base.errors import BtMissionError
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.options import JSON
from bt_mission.cli.parser import Command, Option

EPILOG = """\
examples:
  bt-mission explain BT-203    what is wrong, why, and how it is corrected
  bt-mission explain 203       the same
  bt-mission explain no field  the codes about these words
  bt-mission explain           all codes, with their titles
"""


def explain(options: argparse.Namespace) -> int:
    """Print entries of the catalogue; without a code its list."""
    if options.codes and not any(map(looks_like_code, options.codes)):
        return _find(" ".join(options.codes), options)
    entries = [*map(entry_of, options.codes)] or [*catalogue().values()]
    if options.json:
        print(json.dumps([asdict(entry) for entry in entries], indent=2))
    elif options.codes:
        print("\n\n".join(map(explained, entries)))
    else:
        for group, members in groupby(entries, lambda entry: entry.group):
            print(group)
            for entry in members:
                print(f"  {entry.code:8} {entry.title}")
            print()
        print("bt-mission explain CODE explains one with an example")
    return SUCCESS


def _find(text: str, options: argparse.Namespace) -> int:
    """Print the entries about the words of a message.

    Raises:
        BtMissionError: There is none.
    """
    entries = entries_about(text)
    if not entries:
        message = f"no error is about {quoted(text)}; `bt-mission explain` lists all codes"
        raise BtMissionError(message, code="BT-1101")
    if options.json:
        print(json.dumps([asdict(entry) for entry in entries], indent=2))
        return SUCCESS
    print(f"about {quoted(text)}:")
    for entry in entries:
        print(f"  {entry.code:8} {entry.title}")
    print("\nbt-mission explain CODE explains one with an example")
    return SUCCESS


def explained(entry: CatalogueEntry) -> str:
    """Return an entry as text."""
    parts = [f"{entry.code}: {entry.title}", fill(entry.cause)]
    if entry.wrong:
        line = f", line {entry.line}" if entry.line else ""
        wrong = "Wrong:" if entry.is_command else f"Wrong ({entry.file}{line}):"
        parts += [f"{wrong}\n\n{indent(shown(entry.wrong), '    ')}"]
    parts.append(fill(f"Cure: {entry.cure}"))
    if entry.right:
        parts.append(f"Right:\n\n{indent(shown(entry.right), '    ')}")
    return "\n\n".join(parts)


COMMANDS = {
    "explain": Command(
        explain,
        "Explains the code at the end of an error or a warning: its cause, a minimal example, "
        "and the corrected example. Without a code, lists all codes.",
        (
            Option(
                "codes code",
                "a code, such as BT-203, bt-203 or 203, or words of a message (default: list all "
                "codes)",
                nargs="*",
                completes="codes",
            ),
            JSON.but(help="print a JSON list with an object for each code"),
        ),
        EPILOG,
    )
}
