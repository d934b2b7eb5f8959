"""Standard output and standard error, through which no control character gets."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

from bt_mission.core.text import escape_lines

STANDARD_OUTPUT = "standard output"
"""The file name of an OSError that a write to standard output raises."""


class EscapingStream:
    """A text stream on another one that escapes its lines.

    An OSError of a write has the name of the stream as its file name.

    Args:
        stream: The stream below, which has all other attributes.
        name: The name in errors.

    Attributes:
        unescaped: The stream below, for a library that colours and draws.
    """

    def __init__(self, stream: TextIO, name: str) -> None:
        self.unescaped = stream
        self._name = name

    def write(self, text: str) -> int:
        """Write a text escaped. Return the number of its characters."""
        with self._named_errors():
            self.unescaped.write(escape_lines(text))
        return len(text)

    def flush(self) -> None:
        """Write what is buffered."""
        with self._named_errors():
            self.unescaped.flush()

    def writelines(self, lines: list[str]) -> None:
        """Write texts escaped."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.unescaped, name)

    @contextmanager
    def _named_errors(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            error.filename = self._name
            raise


@contextmanager
def escaped_output() -> Iterator[None]:
    """Have all that Python writes to standard output and error escaped."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (
        cast("TextIO", EscapingStream(stream, name))
        for stream, name in zip(before, (STANDARD_OUTPUT, "standard error"), strict=True)
    )
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def unescaped(stream: TextIO) -> TextIO:
    """The stream below, for a library that writes control sequences."""
    return stream.unescaped if isinstance(stream, EscapingStream) else stream
