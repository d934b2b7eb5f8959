"""The log of all calls of agents: lines of JSON, each with the hash of the line before."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from bt_mission.core.errors import BtMissionError
from bt_mission.core.output import make_folder_of
from bt_mission.core.wall_clock import unix_s

MOST_BYTES = 50_000_000
LONGEST = 300
"""Characters of arguments and outcomes in a line."""
_START = "0" * 64


class LogError(BtMissionError):
    """A log that is damaged, full, or cannot be written."""

    code = "BT-1407"


class CallLog:
    """Appends to a log.

    Args:
        path: The file; its lines are verified first.

    Raises:
        LogError: It is damaged, or cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.count, self._last = verified(path)
        make_folder_of(path)
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
        try:
            self._file = os.fdopen(os.open(path, flags, 0o600), "ab", buffering=0)
        except OSError as error:
            raise LogError(f"{path}: cannot be written ({error.strerror})") from None
        self._size = os.fstat(self._file.fileno()).st_size

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    @property
    def is_full(self) -> bool:
        """Whether no call but `stop` is accepted until the log is moved away."""
        return self._size > MOST_BYTES

    def note(self, client: str, call: str, arguments: Any, outcome: str) -> None:
        """Append a line. Raises LogError if it cannot be written."""
        self.count += 1
        line: dict[str, Any] = {
            "number": self.count,
            "unix_s": round(unix_s(), 3),
            "client": client[:LONGEST],
            "call": call[:LONGEST],
            "arguments": _short(arguments),
            "outcome": outcome[:LONGEST],
            "before": self._last,
        }
        self._last = _hash(line)
        data = json.dumps({**line, "hash": self._last}).encode() + b"\n"
        try:
            self._size += self._file.write(data)
        except OSError as error:
            raise LogError(f"{self.path}: cannot be written ({error.strerror})") from None


def verified(path: Path) -> tuple[int, str]:
    """Return the number of lines of a log, and the hash of its last one.

    Raises:
        LogError: A line is damaged, missing or was changed.
    """
    count, last = 0, _START
    if not path.exists():
        return count, last
    try:
        with path.open("rb") as lines:
            for text in lines:
                line = json.loads(text)
                given = line.pop("hash")
                if (line["before"], line["number"], _hash(line)) != (last, count + 1, given):
                    break
                count, last = count + 1, given
            else:
                return count, last
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        pass
    raise LogError(f"{path}: line {count + 1} is damaged or was changed")


def _hash(line: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(line, sort_keys=True).encode()).hexdigest()


def _short(arguments: Any) -> Any:
    text = json.dumps(arguments, default=str)
    if len(text) <= LONGEST:
        return json.loads(text)
    return {"sha256": hashlib.sha256(text.encode()).hexdigest(), "begins": text[:LONGEST]}
