"""A trace that was written to a file, read back."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import contents_of
from bt_mission.executive.trace import VERSION


class TraceError(BtMissionError):
    """A file that is not a trace, or a trace of another version."""

    code = "BT-1002"


LARGEST_NS = 2**63 - 1
"""Times of ROS are no larger, ns."""


@dataclass(frozen=True)
class StoredTrace:
    """The events of a run.

    Args:
        events: Events in order, as `docs/reference/trace.md` describes them.
        sha256: The hash over its lines; if it is whole, that of the run's report.
        is_cut: Its last line is torn, as after a kill of the process; it is omitted.
    """

    file: str
    events: tuple[dict[str, Any], ...]
    sha256: str
    is_cut: bool

    @property
    def start(self) -> dict[str, Any]:
        """Mission, world, robot and seed; empty if the trace lacks them."""
        return next((event for event in self.events if event["event"] == "start"), {})

    @property
    def start_ns(self) -> int:
        """Virtual time of the first event, ns."""
        return int(self.events[0]["t"]) if self.events else 0

    def seconds(self, event: dict[str, Any]) -> float:
        """When an event was, s since the first."""
        return (int(event["t"]) - self.start_ns) / 1e9


def read_trace(path: Path) -> StoredTrace:
    """Read a trace.

    Raises:
        TraceError: For a file that cannot be read, is no trace, or has another version, with the
            line.
    """
    try:
        raw = contents_of(path)
    except OSError as error:
        raise TraceError(f"{path}: cannot read the trace: {error.strerror}") from error
    lines = raw.split(b"\n")
    is_cut = lines.pop() != b""  # each whole line ends with a line feed
    if not lines:
        raise TraceError(f"{path}: not a trace: {'a torn line' if is_cut else 'an empty file'}")
    return _stored(str(path), lines, is_cut=is_cut)


def trace_of(file: str, lines: Iterable[str]) -> StoredTrace:
    """A trace of lines that a file of another kind holds, such as a recording.

    Raises:
        TraceError: As :func:`read_trace`.
    """
    return _stored(file, [line.encode() for line in lines], is_cut=False)


def _stored(file: str, lines: list[bytes], *, is_cut: bool) -> StoredTrace:
    digest = hashlib.sha256()
    events: list[dict[str, Any]] = []
    for number, line in enumerate(lines, 1):
        digest.update(line + b"\n")
        data = _parsed(line, f"{file}:{number}")
        if number == 1:
            _check_version(data, f"{file}:1")
        elif _is_time(data.get("t")) and isinstance(data.get("event"), str):
            events.append(data)
        else:
            raise TraceError(f"{file}:{number}: not an event: expected 't' in ns and 'event'")
    return StoredTrace(file, tuple(events), digest.hexdigest(), is_cut)


def _is_time(value: Any) -> bool:
    return type(value) is int and abs(value) <= LARGEST_NS


def _parsed(line: bytes, place: str) -> dict[str, Any]:
    try:
        data = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise TraceError(f"{place}: not a line of a trace: expected a JSON object") from error
    if not isinstance(data, dict):
        raise TraceError(f"{place}: not a line of a trace: expected a JSON object")
    return data


def _check_version(data: dict[str, Any], place: str) -> None:
    version = data.get("trace_version")
    if version is None:
        raise TraceError(f"{place}: not a trace: the first line has no version")
    if version != VERSION:
        raise TraceError(f"{place}: a trace of version {version}; this bt-mission reads {VERSION}")
