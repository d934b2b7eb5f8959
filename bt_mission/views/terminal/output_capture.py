"""The output of the process to its terminal while a live view is shown, for that view to show."""

from __future__ import annotations

import os
import sys
import tempfile
from contextlib import ExitStack
from typing import TextIO

CHUNK = 1 << 20


class OutputCapture:
    """Redirects standard output and standard error of terminals, including that of C code.

    A file receives the output: a pipe that is not emptied in time would block the writer.

    Attributes:
        terminal: The terminal while the output is redirected.
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
        """Return the lines that were finished since the last call."""
        sys.stdout.flush()
        read = b"".join(iter(self._next, b""))
        *lines, self._rest = (self._rest + read).split(b"\n")
        return [line.decode(errors="replace") for line in lines]

    def stop(self) -> list[str]:
        """Restore the output; return the remaining lines."""
        self._restore.close()
        lines = self.take()
        self._sink.close()
        return lines + ([self._rest.decode(errors="replace")] if self._rest else [])

    def size(self) -> os.terminal_size:
        """The columns and rows of the terminal; zeros if it does not report them."""
        return os.get_terminal_size(self.terminal.fileno())

    def _next(self) -> bytes:
        read = os.pread(self._sink.fileno(), CHUNK, self._read)
        self._read += len(read)
        return read
