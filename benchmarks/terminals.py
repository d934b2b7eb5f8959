"""`bt-mission` on a terminal of its own, as a person runs it."""

from __future__ import annotations

import fcntl
import os
import pty
import signal
import struct
import sys
import termios
from collections.abc import Iterator
from contextlib import contextmanager

SIZE = struct.pack("HHHH", 45, 140, 0, 0)
"""Rows and columns of the terminal."""


@contextmanager
def on_terminal(*arguments: str) -> Iterator[int]:
    """Run a command until the end of the block; gives the terminal's file, which must be read."""
    child, terminal = pty.fork()
    if child == 0:
        os.environ["TERM"] = "xterm-256color"
        os.execv(sys.executable, [sys.executable, "-m", "bt_mission", *arguments])  # noqa: S606 - ourselves
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, SIZE)
    try:
        yield terminal
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        os.close(terminal)
