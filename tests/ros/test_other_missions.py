"""Two missions on one robot: each names the other, and a goal that is replaced says by whom."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.ros.other_missions import OtherMissions

TURN = "mission: {}\ntree:\n  turn: {{angle: 90}}\n  timeout: 1000000\n"


@pytest.fixture
def warned(ros: Any, monkeypatch: pytest.MonkeyPatch) -> dict[str, list[str]]:
    """The warnings of two missions, once both have come; the second starts a second later."""
    ros.turns = ros.server()
    lines: dict[str, list[str]] = {}
    for name, more in (("patrol", {}), ("dock", {"name": "second"})):
        runner = ros.mission(TURN.format(name), has_controls=True, **more)
        warnings = lines[name] = []
        monkeypatch.setattr(runner, "warn", warnings.append)
        OtherMissions(runner)
        setattr(ros, name, runner)
        ros.run(1.0)
    ros.spin_until(lambda: lines["patrol"] and lines["dock"])
    return lines


def test_each_names_the_other(ros: Any, warned: dict[str, list[str]]) -> None:
    """Once, with its node; whoever has ended is not named any more."""
    ros.run(3.0)
    too = "runs on this robot, too: goals that move the same part replace each other"
    assert warned == {
        "patrol": [f"mission 'dock' (/second) {too}"],
        "dock": [f"mission 'patrol' (/bt_mission) {too}"],
    }
    assert ros.dock.ledger.others() == "mission 'patrol' (/bt_mission)"
    ros.patrol.halt("enough")
    ros.spin_until(lambda: not ros.dock.ledger.others())
    assert ros.patrol.is_done
    assert ros.dock.ledger.others() == ""


@pytest.mark.usefixtures("warned")
@pytest.mark.parametrize("by", ["another", "own"])
def test_a_goal_that_is_replaced_says_by_whom(ros: Any, by: str) -> None:
    """Unless the mission itself has sent the goal that replaces it."""
    goal = ros.turns.goals[0]
    digits = ros.patrol.ledger.open_goals[0].short_id if by == "own" else "0123abcd"
    goal.abort(error_code=1, error_msg=f"replaced by a new goal: {digits} of /turn")
    ros.until(lambda: ros.patrol.is_done)
    who = "" if by == "own" else ", sent by mission 'dock' (/second)"
    assert ros.patrol.executive.reason == (
        f"'turn' aborted: /turn: replaced by a new goal: {digits} of /turn (code 1){who}"
    )
