"""The order in which what an executive tells is taken."""

from __future__ import annotations

from bt_mission.events.events import LogLine, MissionStateChanged
from bt_mission.events.messages import in_order
from tests.support.watched import S, tree


def test_a_mission_ends_last():
    """What it says at that instant may come later; the next mission begins after that."""
    begin, again = tree(run="one"), tree(run="two")
    end, words = MissionStateChanged(S, "one", "m", "success", ""), LogLine(S, "one", "done")
    assert in_order([begin, end, words, again]) == [begin, words, end, again]
    assert in_order([end, again]) == [end, again]
