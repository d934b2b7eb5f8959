"""What the board of a page sends of a mission with many goals."""

from __future__ import annotations

from bt_mission.events.events import GoalChanged, NodeInfo, RunStarted
from bt_mission.events.mission_state import MOST_GOALS, MissionState
from bt_mission.views.web.board import Board


def test_beyond_the_goals_that_a_state_keeps_each_new_one_is_sent_alone():
    """Also by a board whose oldest goal has gone; a page that opens late gets the newest."""
    mission, board = MissionState(), Board()
    mission.apply(RunStarted(0, "run", "m", (NodeInfo("root", "Sequence", "0", 0),)))
    for number in range(MOST_GOALS + 5):
        revision = board.revision
        mission.apply(GoalChanged(number, f"{number:032x}", "/turn", "t", number, "succeeded"))
        board.show(mission, ())
        sent = board.since(revision)
        if number:
            assert "values_are_new" not in sent
            assert [goal[0] for goal in sent["goals"]] == [f"{number:032x}"]
    assert len(board.since(0)["goals"]) == MOST_GOALS
