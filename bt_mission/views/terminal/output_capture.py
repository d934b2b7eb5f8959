"""What the process writes to its terminal past a live view, kept for that view to show."""

from __future__ import annotations

import os
import sys
import tempfile
from contextlib import ExitStack
from typing import TextIO

CHUNK = 1 << 20


class OutputCapture:
    """Takes over standard output and standard error where they are terminals, also from C code.

    A file takes what is written: a pipe that nobody empties in time would block who writes.

    Attributes:
        terminal: The way to the terminal while it is taken over.
    """

    def __init__(self) -> None:
        self.terminal: TextIO = os.fdopen(
            os.dup(sys.stdout.fileno()),
            "w",
            encoding=sys.stdout.encoding,
            errors="replace",
        )
        self._restore = ExitStack()
        self._sink = tempfile.TemporaryFile()  # noqa: SIM115 - closed by `stop`
        self._read = 0
        self._rest = b""

    def start(self) -> None:
        """Take over what is written from now on."""
        for stream in (sys.stdout, sys.stderr):
            if stream.isatty():
                stream.flush()
                number = stream.fileno()
                former = os.dup(number)
                os.dup2(self._sink.fileno(), number)
                self._restore.callback(os.close, former)
                self._restore.callback(os.dup2, former, number)
                self._restore.callback(stream.flush)

    def take(self) -> list[str]:
        """Return the lines that were finished since it was last asked."""
        sys.stdout.flush()
        read = b"".join(iter(self._next, b""))
        *lines, self._rest = (self._rest + read).split(b"\n")
        return [line.decode(errors="replace") for line in lines]

    def stop(self) -> list[str]:
        """Give everything back; return the lines that are left."""
        self._restore.close()
        lines = self.take()
        self._sink.close()
        return lines + ([self._rest.decode(errors="replace")] if self._rest else [])

    def size(self) -> os.terminal_size:
        """Columns and rows of the terminal; zeros where it does not tell."""
        return os.get_terminal_size(self.terminal.fileno())

    def _next(self) -> bytes:
        read = os.pread(self._sink.fileno(), CHUNK, self._read)
        self._read += len(read)
        return read
