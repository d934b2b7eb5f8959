"""Transcripts: files with inputs, each behind a `$`, and with the output that follows from it.

Set WRITE_TRANSCRIPTS=1 to write what the outputs are now, and read the difference.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

from bt_mission.base.commands import hints


def transcripts_of(test_file: str) -> list[Path]:
    """Return the transcripts in the folder beside a file of tests."""
    return sorted(Path(test_file).with_name("transcripts").glob("*.txt"))


def head_of(path: Path) -> str:
    """Return what stands before the first input of a transcript."""
    return re.split(r"^\$ ?", path.read_text(encoding="utf-8"), flags=re.MULTILINE)[0]


def assert_transcript(path: Path, output_of: Callable[[str], str]) -> None:
    """Compare the outputs of a transcript with those of a function, as one text.

    Args:
        path: Of the transcript.
        output_of: Returns the output of an input, which is the rest of its line.
    """
    expected = path.read_text(encoding="utf-8")
    head, *entries = re.split(r"^\$ ?", expected, flags=re.MULTILINE)
    actual = head
    for entry in entries:
        line = entry.partition("\n")[0]
        output = output_of(line)
        actual += f"$ {line}".rstrip() + f"\n{output}"
        actual += "\n" if output and not output.endswith("\n") else ""
    assert_written(path, actual)


def assert_written(path: Path, actual: str) -> None:
    """Compare a text with a file, or write it there where WRITE_TRANSCRIPTS is set.

    Without the commands that messages name, these say something else.
    """
    if "WRITE_TRANSCRIPTS" in os.environ:
        path.write_text(actual, encoding="utf-8")
    expected = path.read_text(encoding="utf-8")
    if not hints("page"):
        expected = re.sub(r"['`]bt-mission docs ([\w#-]+)['`]", r"the page \1", expected)
    if not hints("topic_type"):
        expected = re.sub(r"; '[^']*' names the types of a running graph", "", expected)
    assert actual == expected
