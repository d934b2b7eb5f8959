"""What a page of the documentation says to save and to type, in its order."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass

_BLOCK = re.compile(
    r"^(?P<indent> *)```(?P<language>[\w-]*)(?: (?P<file>\S+))?\n(?P<text>.*?)^(?P=indent)```$",
    re.MULTILINE | re.DOTALL,
)
_HEAD = re.compile(r"# (\S+\.(?:yaml|py))\n")
_COMMAND = re.compile(
    r"^(?:\$ )?(?:\w+=\S+ )*"
    r"(?:bt-mission|pip|pytest|python3?|ros2|sudo|docker|dask|uv|make|source) ",
    re.MULTILINE,
)


@dataclass(frozen=True)
class Saved:
    """A file that the reader saves."""

    file: str
    text: str


@dataclass(frozen=True)
class Typed:
    """A command.

    Attributes:
        command: With what follows a backslash at the end of a line.
        expected: The output that stands below it, "..." for anything; None without any.
    """

    command: str
    expected: str | None


def steps_of(page: str) -> Iterator[Saved | Typed]:
    """Yield what the text of a page says to do.

    A block ``LANGUAGE FILE`` is a file, and so is one whose first line is the comment ``# FILE``.
    A block ``console`` has commands behind "$ ", each with its output; a block ``sh`` has commands
    alone.
    """
    for block in _BLOCK.finditer(page):
        text = textwrap.dedent(block["text"])
        if file := block["file"] or _named_in(text):
            yield Saved(file, text)
        elif block["language"] == "console":
            for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
                command, _, output = _command_and_rest(part)
                yield Typed(command, output or None)
        elif block["language"] == "sh":
            while text:
                command, _, text = _command_and_rest(text)
                if command:
                    yield Typed(command, None)


def _named_in(text: str) -> str | None:
    """Return the name of a file in the comment with which its text begins."""
    name = _HEAD.match(text)
    return name and name[1]


def _command_and_rest(text: str) -> tuple[str, str, str]:
    """Split the text of a shell behind its first command."""
    command, end, rest = text.partition("\n")
    while command.endswith("\\") or rest.startswith("> "):
        more, end, rest = rest.removeprefix("> ").partition("\n")
        command += f"\n{more}"
    return command, end, rest


def unmarked(page: str) -> list[str]:
    """Return the first lines of blocks that hold commands and are marked otherwise."""
    return [
        block["text"].strip().splitlines()[0]
        for block in _BLOCK.finditer(page)
        if block["language"] not in ("console", "sh", "text", "yaml", "python")
        and _COMMAND.search(textwrap.dedent(block["text"]))
    ]
