"""What a page is told of who can be watched."""

from __future__ import annotations

import pytest

from bt_mission.views.web.live import LiveMission
from bt_mission.views.web.shown_mission import OpenPanels
from tests.support.watched import ScriptedExecutive, ScriptedGraph


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
