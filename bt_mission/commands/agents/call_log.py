"""The log of the calls of agents: a line of JSON for each.

Servers on one folder may write to it together: a line is written whole, behind a lock. A line that
could not be written waits for the next call, so a disk that was full for a moment costs none. A
line that is cut, as by a loss of power, costs itself only: the next one begins on a line of its
own, and a reader counts it.

A process that may write the file may change it, and nothing here would show that. The log is a
record for people, as honest as the account of `bt-mission mcp`.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import stat
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bt_mission.base.errors import BtMissionError
from bt_mission.base.output import make_folder_of
from bt_mission.base.text import counted
from bt_mission.base.wall_clock import unix_s

MOST_BYTES = 50_000_000
MOST_WAITING = 200
"""Lines that wait for the file."""
LONGEST = 300
"""Characters of arguments and outcomes in a line."""
_MOST_NAMED = 5


class LogError(BtMissionError):
    """A log that is full, or cannot be written."""

    code = "BT-1407"


class CallLog:
    """Appends to a log.

    Args:
        path: The file. One that is damaged is continued.

    Raises:
        LogError: It cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        make_folder_of(path)
        flags = os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC | os.O_NONBLOCK
        try:
            self._file = os.open(path, flags, 0o600)
        except OSError as error:
            raise LogError(f"{path}: cannot be written ({error.strerror})") from None
        _refuse_special(self._file, path)
        self._waiting: deque[bytes] = deque()
        self._is_closed = False

    def close(self) -> None:
        """Write what waits, if possible, and close the file; further calls do nothing."""
        if not self._is_closed:
            with suppress(LogError):
                self.write()
            self._is_closed = True
            os.close(self._file)

    @property
    def is_full(self) -> bool:
        """Whether no call but `stop` is accepted until the log is moved away."""
        return os.fstat(self._file).st_size > MOST_BYTES

    def note(self, client: str, call: str, arguments: Any, outcome: str) -> None:
        """Append a line; it waits while another process writes.

        Raises:
            LogError: It cannot be written now. It waits, unless too many do.
        """
        if len(self._waiting) >= MOST_WAITING:
            self.write()
        line = {
            "unix_s": round(unix_s(), 3),
            "client": client[:LONGEST],
            "call": call[:LONGEST],
            "arguments": _short(arguments),
            "outcome": outcome[:LONGEST],
        }
        self._waiting.append(json.dumps(line).encode() + b"\n")
        self.write()

    def write(self) -> None:
        """Write the lines that wait, unless another process writes.

        Raises:
            LogError: They cannot be written, or too many wait for the other process.
        """
        if not self._waiting:
            return
        try:
            with _locked(self._file) as is_mine:
                while is_mine and self._waiting:
                    self._append(self._waiting[0])
                    self._waiting.popleft()
        except OSError as error:
            raise LogError(f"{self.path}: cannot be written ({error.strerror})") from None
        if len(self._waiting) >= MOST_WAITING:
            raise LogError(f"{self.path}: another process holds it; {MOST_WAITING} lines wait")

    def _append(self, line: bytes) -> None:
        """Append a line as a whole, or nothing. Raises OSError."""
        size = os.fstat(self._file).st_size
        if size and os.pread(self._file, 1, size - 1) != b"\n":
            line = b"\n" + line
        written = os.write(self._file, line)
        if written < len(line):
            os.ftruncate(self._file, size)
            raise OSError(28, "no space left on the device")


@dataclass(frozen=True)
class LogState:
    """The content of a log.

    Attributes:
        calls: The number of its whole lines.
        damaged: The numbers of the other lines, from 1.
    """

    calls: int
    damaged: tuple[int, ...] = ()

    def __str__(self) -> str:
        counts = f"log of calls: {counted(self.calls, 'call')}"
        if not self.damaged:
            return counts
        named = ", ".join(map(str, self.damaged[:_MOST_NAMED]))
        more = ", ..." if len(self.damaged) > _MOST_NAMED else ""
        return f"{counts}; {counted(len(self.damaged), 'line')} cannot be read: {named}{more}"


def read_log(path: Path) -> LogState:
    """Count the lines of a log; a missing file has no lines. Raises LogError."""
    calls, damaged = 0, []
    try:
        number = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except FileNotFoundError:
        return LogState(0)
    except OSError as error:
        raise LogError(f"{path}: cannot be read ({error.strerror})") from None
    _refuse_special(number, path)
    with os.fdopen(number, "rb") as lines:
        for at, line in enumerate(lines.read(2 * MOST_BYTES).split(b"\n"), 1):
            if _is_call(line):
                calls += 1
            elif line:
                damaged.append(at)
    return LogState(calls, tuple(damaged))


def _refuse_special(file: int, path: Path) -> None:
    if not stat.S_ISREG(os.fstat(file).st_mode):
        os.close(file)
        raise LogError(f"{path}: expected a file")


def _is_call(line: bytes) -> bool:
    try:
        return isinstance(json.loads(line), dict)
    except (ValueError, RecursionError):
        return False


@contextmanager
def _locked(file: int) -> Iterator[bool]:
    """Hold the lock of a file; yield False, at once, while another process holds it."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        yield False
        return
    try:
        yield True
    finally:
        fcntl.flock(file, fcntl.LOCK_UN)


def _short(arguments: Any) -> Any:
    text = json.dumps(arguments, default=str)
    if len(text) <= LONGEST:
        return json.loads(text)
    return {"sha256": hashlib.sha256(text.encode()).hexdigest(), "begins": text[:LONGEST]}
