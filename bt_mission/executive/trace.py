"""What happened in a run, as lines that two runs can be compared by.

One event is one line of JSON with sorted keys: ``{"t": nanoseconds, "event": name, ...}``.
:attr:`Trace.sha256` is the hash over all lines so far, each followed by a line feed; it starts
with a line that names the version of this format. Floats are written so that they read back
exactly, so one differing bit in a pose changes the hash.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

from bt_mission.core.listeners import Listeners
from bt_mission.core.output import DELETED, OutputFile
from bt_mission.goals.goal import Goal

VERSION = 2
KEPT_EVENTS = 200
_ENCODER = json.JSONEncoder(sort_keys=True)  # json.dumps makes a new one for each event
_json = json.encoder.encode_basestring_ascii  # what the encoder writes a text with


class Trace:
    """Hashes events as they happen, keeps the newest, and tells listeners.

    Args:
        keep: How many of the newest events to keep.
        hide: Texts that differ from machine to machine, such as a folder's path, each with what is
            written in their place.
    """

    def __init__(self, keep: int = KEPT_EVENTS, hide: Mapping[str, str] | None = None) -> None:
        self._hide = {json.dumps(text)[1:-1]: shown for text, shown in (hide or {}).items()}
        self._hash = hashlib.sha256()
        self._seedless_hash = hashlib.sha256()
        self._goal_numbers: dict[bytes, int] = {}
        self.newest: deque[str] = deque(maxlen=keep)
        self.listeners: Listeners[[str]] = Listeners()
        self.raised: list[Exception] = []
        """By listeners, and not yet taken by the executive."""
        self._add(json.dumps({"trace_version": VERSION}))

    @property
    def sha256(self) -> str:
        """The hash over everything recorded so far, in hexadecimal."""
        return self._hash.hexdigest()

    @property
    def seedless_sha256(self) -> str:
        """The same hash without the seed, and with the number of each goal in place of its id.

        It is equal for two runs in which the same things happened, whatever their seeds.
        """
        return self._seedless_hash.hexdigest()

    def record(self, time_ns: int, event: str, **fields: Any) -> None:
        """Add an event at a time of the ROS clock."""
        line = _ENCODER.encode({"t": time_ns, "event": event, **fields})
        if "seed" in fields:
            del fields["seed"]
            self._add(line, _ENCODER.encode({"t": time_ns, "event": event, **fields}))
        else:
            self._add(line)

    # The two events of which there are many, put together by hand as `record` would write them.

    def record_status(self, time_ns: int, node: str, path: str, status: str, message: str) -> None:
        """Add that a node has another status."""
        self._add(
            f'{{"event": "status", "message": {_json(message)}, "node": {_json(node)},'
            f' "path": {_json(path)}, "status": {_json(status)}, "t": {time_ns}}}'
        )

    def record_goal(self, time_ns: int, what: str, goal: Goal) -> None:
        """Add what has happened to a goal."""
        status = "null" if goal.status is None else f"{goal.status:d}"
        start = f'{{"action": {_json(goal.goal_client.name)}, "event": {_json(f"goal {what}")},'
        end = (
            f' "owner": {_json(goal.owner)}, "phase": {_json(goal.phase)}, "status": {status},'
            f' "t": {time_ns}}}'
        )
        number = self._goal_numbers.setdefault(goal.id, len(self._goal_numbers))
        self._add(f'{start} "goal": "{goal.id.hex()}",{end}', f'{start} "goal": {number},{end}')

    def record_pose(self, time_ns: int, pose: tuple[float, float, float], collisions: int) -> None:
        """Add where the robot truly is (m, m, rad), and how often it has run into something."""
        x, y, yaw = pose
        if not math.isfinite(x + y + yaw):
            self.record(time_ns, "pose", x=x, y=y, yaw=yaw, collisions=collisions)
            return
        self._add(
            f'{{"collisions": {collisions}, "event": "pose", "t": {time_ns},'
            f' "x": {x!r}, "y": {y!r}, "yaw": {yaw!r}}}'
        )

    def _add(self, line: str, seedless: str | None = None) -> None:
        """Add a line.

        Args:
            seedless: The same without what the seed alone decides; None where that is the line.
        """
        for text, shown in self._hide.items():
            line = line.replace(text, shown)
            seedless = seedless and seedless.replace(text, shown)
        written = line.encode() + b"\n"
        self._hash.update(written)
        self._seedless_hash.update(written if seedless is None else seedless.encode() + b"\n")
        self.newest.append(line)
        self.raised += self.listeners.notify(line)


class TraceFile:
    """Writes every line of a trace to a file as it comes: the newest so far, and all from now on.

    Once a write fails nothing more is written, and :attr:`missing` says what the file lacks.

    Args:
        trace: Of a mission.
        path: See :class:`OutputFile`.

    Raises:
        BtMissionError: When the file cannot be opened.
    """

    def __init__(self, trace: Trace, path: Path) -> None:
        self.file = OutputFile(path)
        self._trace = trace
        self._first = trace.newest[1] if len(trace.newest) > 1 else ""
        self._lost = ""
        """The first line that the file lacks."""
        for line in trace.newest:
            self._take(line)
        trace.listeners.append(self._take)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.close(replaces=kind is None)

    @property
    def missing(self) -> str:
        """What the file lacks, in words; empty when it lacks nothing."""
        if self.file.is_deleted:
            return DELETED
        if self.file.fault is None:
            return ""
        first, lost = (_time_ns(line) for line in (self._first, self._lost))
        return f"everything after {max(0, lost - first) / 1e9:.1f} s ({self.file.fault})"

    def close(self, *, replaces: bool = True) -> None:
        """Write no more; once is enough."""
        self._trace.listeners.remove(self._take)
        self.file.close(replaces=replaces)

    def _take(self, line: str) -> None:
        if self.file.fault is not None:
            return
        try:
            self.file.stream.write(f"{line}\n".encode())
            self.file.stream.flush()
        except OSError as error:
            self._lost = line
            self.file.abandon(error.strerror or str(error))


def _time_ns(line: str) -> int:
    return int(json.loads(line).get("t", 0)) if line else 0
