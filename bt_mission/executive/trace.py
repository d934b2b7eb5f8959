"""The events of a run, as lines by which two runs can be compared.

One event is one line of JSON (:mod:`bt_mission.executive.events.codec`). :attr:`Trace.sha256` is
the hash over all lines so far, each followed by a line feed; it starts with a line that names the
version of this format. One differing bit in a pose changes the hash.
"""

from __future__ import annotations

import hashlib
import json
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Self

from bt_mission.base.output import DELETED, OutputFile
from bt_mission.executive.events.codec import goal_line, node_names, trace_line
from bt_mission.executive.events.events import (
    Event,
    EventStream,
    GoalChanged,
    NodeInfo,
    RunStarted,
    TreeRevised,
)
from bt_mission.executive.listeners import Stream

VERSION = 3
KEPT_LINES = 200


class Trace:
    """Hashes events as they happen, keeps the newest lines, and hands each line on.

    Args:
        keep: How many of the newest lines to keep.
        hide: Texts that differ from machine to machine, such as a folder's path, each with what is
            written in their place.
    """

    def __init__(self, keep: int = KEPT_LINES, hide: Mapping[str, str] | None = None) -> None:
        self._hide = {json.dumps(text)[1:-1]: shown for text, shown in (hide or {}).items()}
        self._hash = hashlib.sha256()
        self._seedless_hash = hashlib.sha256()
        self._goal_numbers: dict[str, int] = {}
        self._nodes: tuple[NodeInfo, ...] = ()
        self._names: tuple[str, ...] = ()
        self.lines: Stream[str] = Stream()
        """Each line, as it is added."""
        self.newest: deque[str] = deque(maxlen=keep)
        self._add(json.dumps({"trace_version": VERSION}))

    @property
    def sha256(self) -> str:
        """The hash over everything recorded so far, in hexadecimal."""
        return self._hash.hexdigest()

    @property
    def seedless_sha256(self) -> str:
        """The hash without the seed, and with the number of each goal in place of its id.

        It is equal for two runs with the same events, whatever their seeds.
        """
        return self._seedless_hash.hexdigest()

    def follow(self, events: EventStream, nodes: Sequence[NodeInfo]) -> None:
        """Take the events of a mission with these nodes."""
        self._nodes, self._names = tuple(nodes), node_names(nodes)
        events.subscribe(self._take)

    def _take(self, event: Event) -> None:
        if isinstance(event, TreeRevised):
            self._nodes, self._names = event.nodes, node_names(event.nodes)
        line = trace_line(event, self._nodes, self._names)
        if line is None:
            return
        match event:
            case RunStarted():
                self._add(line, trace_line(replace(event, seed=0), self._nodes, self._names))
            case GoalChanged(id=goal):
                number = self._goal_numbers.setdefault(goal, len(self._goal_numbers))
                self._add(line, goal_line(event, str(number)))
            case _:
                self._add(line)

    def _add(self, line: str, seedless: str | None = None) -> None:
        """Add a line.

        Args:
            seedless: The line without what only the seed decides; None if that is the line.
        """
        for text, shown in self._hide.items():
            line = line.replace(text, shown)
            seedless = seedless and seedless.replace(text, shown)
        written = line.encode() + b"\n"
        self._hash.update(written)
        self._seedless_hash.update(written if seedless is None else seedless.encode() + b"\n")
        self.newest.append(line)
        self.lines.emit(line)


class TraceFile:
    """Writes every line of a trace to a file: the lines so far, and new lines as they are added.

    After a write has failed nothing more is written, and :attr:`missing` says what the file lacks.

    Args:
        trace: The trace of a mission.
        path: See :class:`OutputFile`.

    Raises:
        BtMissionError: The file cannot be opened.
    """

    def __init__(self, trace: Trace, path: Path) -> None:
        self.file = OutputFile(path)
        self._trace = trace
        self._first = trace.newest[1] if len(trace.newest) > 1 else ""
        self._lost = ""
        """The first line that the file lacks."""
        for line in trace.newest:
            self._take(line)
        trace.lines.subscribe(self._take)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.close(replaces=kind is None)

    @property
    def missing(self) -> str:
        """The missing part of the file, as text; empty if it is complete."""
        if self.file.is_deleted:
            return DELETED
        if self.file.write_error is None:
            return ""
        first, lost = (_time_ns(line) for line in (self._first, self._lost))
        return f"everything after {max(0, lost - first) / 1e9:.1f} s ({self.file.write_error})"

    def close(self, *, replaces: bool = True) -> None:
        """Stop writing; further calls do nothing."""
        self._trace.lines.unsubscribe(self._take)
        self.file.close(replaces=replaces)

    def _take(self, line: str) -> None:
        if self.file.write_error is not None:
            return
        try:
            self.file.stream.write(f"{line}\n".encode())
            self.file.stream.flush()
        except OSError as error:
            self._lost = line
            self.file.abandon(error.strerror or str(error))


def _time_ns(line: str) -> int:
    return int(json.loads(line).get("t", 0)) if line else 0
