"""Standard output and standard error, through which no control character gets."""

from __future__ import annotations

import fcntl
import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

from bt_mission.base.text import escape_lines

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


def open_standard_streams() -> None:
    """Open those that are closed, as by ``>&-``, on nothing.

    The next file to be opened would be taken for one of them, also by libraries in C.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
    for name, number in (("stdout", 1), ("stderr", 2)):
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, "w", encoding="utf-8", closefd=False))  # noqa: SIM115


def keep_output_for_python() -> None:
    """Send what others than Python write to standard output to standard error.

    Fast DDS prints its errors there, in the middle of what another program reads. On a terminal
    everything stays as it is.
    """
    stream = sys.stdout
    if not isinstance(stream, io.TextIOWrapper) or stream.isatty():
        return
    stream.flush()
    number = stream.fileno()
    own = fcntl.fcntl(number, fcntl.F_DUPFD_CLOEXEC, 3)  # not that of a closed standard error
    sys.stdout = io.TextIOWrapper(
        os.fdopen(own, "wb", 0 if isinstance(stream.buffer, io.RawIOBase) else -1),
        encoding=stream.encoding,
        errors=stream.errors,
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )
    try:
        os.dup2(2, number)
    except OSError:  # it is closed
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, number)
        os.close(nowhere)


def unescaped(stream: TextIO) -> TextIO:
    """The stream below, for a library that writes control sequences."""
    return stream.unescaped if isinstance(stream, EscapingStream) else stream
