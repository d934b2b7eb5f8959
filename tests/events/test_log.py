"""What stands in the log, and what does not."""

from __future__ import annotations

from py_trees.common import Status

from bt_mission.events.events import LogLine, NodeChanged, NodeInfo, RunStarted, StateChanged
from bt_mission.events.log import LogEntry
from bt_mission.events.mission_state import MissionState
from tests.support.watched import S, tree


def entry(status: Status, message: str = "", *, kind: str = "ActionLeaf") -> LogEntry | None:
    """The line for a change of a leaf, at one second."""
    nodes = (NodeInfo("patrol", "Sequence", "0", 0), NodeInfo("drive", kind, "0.0", 0))
    mission = MissionState()
    mission.apply(RunStarted(S, "run", "patrol", nodes))
    return mission.entry_of(NodeChanged(S, 1, status, message))


def test_leaves_start_and_end():
    """What they say while they run changes all the time, and is in the tree."""
    assert entry(Status.RUNNING, "sent") == LogEntry(S, Status.RUNNING, "drive", "")
    assert entry(Status.FAILURE, "aborted") == LogEntry(S, Status.FAILURE, "drive", "aborted")
    assert entry(Status.INVALID, "halted") == LogEntry(S, Status.INVALID, "drive", "halted")


def test_what_follows_from_other_lines_is_left_out():
    """Composites, halted leaves that say nothing, log nodes, and what was before the watcher."""
    mission = MissionState()
    mission.apply(tree())
    assert mission.entry_of(NodeChanged(S, 0, Status.RUNNING, "")) is None
    assert entry(Status.INVALID) is None
    assert entry(Status.SUCCESS, "hi", kind="Log") is None
    assert mission.entry_of(NodeChanged(None, 1, Status.SUCCESS, "")) is None


def test_words_and_the_state_of_the_mission_stand_in_it():
    """An executive that is idle has none."""
    mission = MissionState()
    assert mission.entry_of(LogLine(S, "hello")) == LogEntry(S, None, "", "hello")
    assert mission.entry_of(tree()) == LogEntry(S, None, "explore", "begins")
    assert mission.entry_of(StateChanged(S, "r", "m", "paused", "by hand")) == LogEntry(
        S, None, "mission paused", "by hand"
    )
    paused = StateChanged(S, "r", "m", "paused", "paused on request", ("'drive'",))
    assert mission.entry_of(paused) == LogEntry(
        S, None, "mission paused on request; still running: 'drive'", ""
    )
    assert mission.entry_of(StateChanged(S, "", "", "idle", "")) is None
