"""What happens in a mission as lines of a log."""

from __future__ import annotations

from dataclasses import dataclass

from py_trees.common import Status

from bt_mission.events.events import (
    LogLine,
    MissionEvent,
    MissionStarted,
    MissionStateChanged,
    NodeStatusChanged,
)

LOG_ENTRIES = 1_000
"""Lines that a view keeps."""

LOG_KIND = "Log"
"""The class of nodes that speak; what they say is in the log as it is said."""


@dataclass(frozen=True)
class LogEntry:
    """A line of the log: a leaf that starts or ends, or something that is said.

    Args:
        status: That of the leaf; None for what is said.
        name: Of the leaf, or what the mission's state is.
    """

    time_ns: int
    status: Status | None
    name: str
    text: str


def entry_of(happening: MissionEvent) -> LogEntry | None:
    """Return the line for a happening; None for those that a log need not have.

    Composites follow from their leaves, and what was the case before the watcher came is in the
    tree.
    """
    match happening:
        case MissionStarted(time_ns, mission=mission):
            return LogEntry(time_ns, None, mission, "begins")
        case NodeStatusChanged(int() as time_ns, _, node, status, message, True) if (
            node.kind != LOG_KIND
        ):
            if status is Status.INVALID and not message:
                return None  # made ready to run once more
            return LogEntry(time_ns, status, node.name, "" if status is Status.RUNNING else message)
        case LogLine(time_ns, text=text):
            return LogEntry(time_ns, None, "", text)
        case MissionStateChanged(time_ns, str(run), _, state, reason) if run:
            return LogEntry(time_ns, None, f"mission {state}", reason)
    return None
