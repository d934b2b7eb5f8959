"""The order in which messages of an executive are taken."""

from __future__ import annotations

from bt_mission.events.events import LogLine, StateChanged
from bt_mission.events.feed import in_order
from bt_mission.events.messages import Batch
from tests.support.watched import S, tree


def test_a_mission_ends_last():
    """What it says at that instant may come later; the next mission begins after that."""
    begin, again = Batch("one", (tree(run="one"),)), Batch("two", (tree(run="two"),))
    end = Batch("one", (StateChanged(S, "one", "m", "success", ""),))
    words = Batch("one", (LogLine(S, "done"),))
    assert in_order([begin, end, words, again]) == [begin, words, end, again]
    assert in_order([end, again]) == [end, again]
