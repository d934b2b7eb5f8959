"""A run as plain lines: what each leaf started, how it ended, and why."""

from __future__ import annotations

from collections.abc import Callable
from typing import TextIO

from py_trees.common import Status

from bt_mission.behaviours.leaves import Log
from bt_mission.events.status_marks import glyphs_for
from bt_mission.executive.executive import Change


class PlainLines:
    """Writes a line whenever a leaf starts or ends.

    :param stream: where to write.
    :param start_ns: gives the ROS time of the start; lines show seconds since then.
    """

    def __init__(self, stream: TextIO, start_ns: Callable[[], int]) -> None:
        self._stream = stream
        self._start_ns = start_ns
        self._glyphs = glyphs_for(stream.encoding)

    def on_change(self, change: Change) -> None:
        """Show a change of a leaf's status; composites follow from their leaves."""
        if change.node.children or isinstance(change.node, Log):
            return  # what a log leaf says is shown as it is said
        words = "" if change.status is Status.RUNNING else change.message
        self._line(change.time_ns, f"{self._glyphs[change.status]} {change.node.name}  {words}")

    def say(self, time_ns: int, text: str) -> None:
        """Show what a mission says."""
        self._line(time_ns, f"  {text}")

    def _line(self, time_ns: int, text: str) -> None:
        seconds = (time_ns - self._start_ns()) / 1e9
        print(f"{seconds:9.2f} s  {text}".rstrip(), file=self._stream, flush=True)
