"""What the board of a page is told of a mission, and who can be watched."""

from __future__ import annotations

import math
from typing import Any

import pytest

from bt_mission.executive.events import messages
from bt_mission.executive.events.events import GoalChanged, NodeInfo, RunStarted
from bt_mission.executive.events.mission_state import MOST_GOALS, MissionState
from bt_mission.views.web import board
from bt_mission.views.web.live import LiveMission, OpenPanels
from tests.support.watched import ScriptedExecutive, ScriptedGraph, goal_in


@pytest.mark.parametrize(("is_fleet", "names"), [(True, ["/one", "/two"]), (False, [])])
def test_of_a_fleet_another_robot_can_be_chosen_at_any_time(
    is_fleet: bool,  # noqa: FBT001 - a parameter of the test
    names: list[str],
) -> None:
    """Elsewhere, who is watched stays so."""
    graph = ScriptedGraph(ScriptedExecutive(name="/one"), ScriptedExecutive(name="/two"))
    shown = LiveMission(graph, "/one", is_fleet=is_fleet)
    shown.attach("/one")
    shown.look(OpenPanels())
    choices = shown.board.since(0)["choices"]
    assert [name for name, _ in choices] == names


def test_the_robot_is_put_on_the_board_when_it_has_told_something(
    executive: ScriptedExecutive, shown: LiveMission
) -> None:
    """Where it is sent is, too; what it told while no map was open is not lost."""

    def changes_since(revision: int, *, is_open: bool = True) -> dict[str, Any]:
        shown.look(OpenPanels(map=is_open))
        return shown.board.robot_since(revision)

    changes_since(0)
    executive.show((messages.FrameTransform("map", "base_link", 1.0, 2.0, 0.0),))
    revision = shown.board.revision
    changes_since(revision, is_open=False)
    assert changes_since(revision)["pose"] == [1.0, 2.0, 0.0]
    revision = shown.board.revision
    goal = goal_in("active", (3.0, 4.0), goal_id="1", action="/drive", owner="drive")
    executive.detail(goals_sent=1, goals=(goal,))
    assert changes_since(revision) == {"targets": [[3.0, 4.0]]}


def test_what_is_no_place_is_left_out_of_the_map(
    executive: ScriptedExecutive, shown: LiveMission
) -> None:
    """A lidar in a frame that is nowhere would be no JSON."""
    executive.show(
        (messages.FrameTransform("map", "base_scan", math.nan, 0.0, 0.0),),
        messages.ScanPoints("base_scan", 0.0, 0.1, 0.1, 3.5, (1.0, 2.0)),
    )
    shown.look(OpenPanels(map=True))
    assert shown.board.robot_since(0)["scan"] == []


def test_the_changes_of_nodes_are_kept_for_pages_that_open_late(
    executive: ScriptedExecutive, shown: LiveMission, monkeypatch: pytest.MonkeyPatch
):
    """All of them since the start; of older ones beyond a bound, the last of each node."""
    monkeypatch.setattr(board, "MOST_CHANGES", 4)
    executive.change(1.0, drive="running")
    executive.change(1.0, drive="failure: blocked", turn_away="running")
    shown.look(OpenPanels())
    past = shown.board.since(0)["past"]
    drive, turn = [3, 1, ""], [4, 1, ""]
    changes = [[1.0, *drive], [2.0, 3, 3, "blocked"], [2.0, *turn]]
    assert past == {"begin": 0.0, "changes": changes}
    executive.change(1.0, drive="running")
    executive.change(1.0, drive="success")
    shown.look(OpenPanels())
    assert shown.board.since(0)["past"] == {
        "begin": 2.0,
        "changes": [[2.0, 3, 3, "blocked"], [2.0, *turn], [3.0, *drive], [4.0, 3, 2, ""]],
    }


def test_beyond_the_goals_that_a_state_keeps_each_new_one_is_sent_alone():
    """Also by a board whose oldest goal has gone; a page that opens late gets the newest."""
    mission, shown = MissionState(), board.Board()
    mission.apply(RunStarted(0, "run", "m", (NodeInfo("root", "Sequence", "0", 0),)))
    for number in range(MOST_GOALS + 5):
        revision = shown.revision
        mission.apply(GoalChanged(number, f"{number:032x}", "/turn", "t", number, "succeeded"))
        shown.show(mission, ())
        sent = shown.since(revision)
        if number:
            assert "values_are_new" not in sent
            assert [goal[0] for goal in sent["goals"]] == [f"{number:032x}"]
    assert len(shown.since(0)["goals"]) == MOST_GOALS
