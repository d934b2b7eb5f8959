"""What stands in the log, and what does not."""

from __future__ import annotations

from py_trees.common import Status

from bt_mission.events.events import (
    LogLine,
    MissionStateChanged,
    NodeInfo,
    NodeStatusChanged,
)
from bt_mission.events.log import LogEntry, entry_of
from tests.support.watched import S, tree

DRIVE = NodeInfo("drive", "ActionLeaf", "0.1", 0)


def change(
    status: Status, message: str = "", *, node: NodeInfo = DRIVE, leaf: bool = True
) -> NodeStatusChanged:
    """A change of a node, at one second."""
    return NodeStatusChanged(S, 1, node, status, message, leaf)


def test_leaves_start_and_end():
    """What they say while they run changes all the time, and is in the tree."""
    assert entry_of(change(Status.RUNNING, "sent")) == LogEntry(S, Status.RUNNING, "drive", "")
    assert entry_of(change(Status.FAILURE, "aborted")) == LogEntry(
        S, Status.FAILURE, "drive", "aborted"
    )
    assert entry_of(change(Status.INVALID, "halted")) == LogEntry(
        S, Status.INVALID, "drive", "halted"
    )


def test_what_follows_from_other_lines_is_left_out():
    """Composites, leaves made ready again, log nodes, and what was before the watcher came."""
    assert entry_of(change(Status.RUNNING, leaf=False)) is None
    assert entry_of(change(Status.INVALID)) is None
    assert entry_of(change(Status.SUCCESS, "hi", node=NodeInfo("say", "Log", "0.1", 0))) is None
    assert entry_of(NodeStatusChanged(None, 1, DRIVE, Status.SUCCESS, "", True)) is None


def test_words_and_the_state_of_the_mission_stand_in_it():
    """An executive that is idle has none."""
    assert entry_of(LogLine(S, "r", "hello")) == LogEntry(S, None, "", "hello")
    assert entry_of(tree()) == LogEntry(S, None, "explore", "begins")
    assert entry_of(MissionStateChanged(S, "r", "m", "paused", "by hand")) == LogEntry(
        S, None, "mission paused", "by hand"
    )
    assert entry_of(MissionStateChanged(S, "r", "m", "paused", "paused on request")) == LogEntry(
        S, None, "mission paused on request", ""
    )
    assert entry_of(MissionStateChanged(S, "", "", "idle", "")) is None
