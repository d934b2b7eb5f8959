"""Facts about the adapter that do not depend on the action; the others are in test_contract_*."""

from __future__ import annotations

from typing import Any

from bt_mission_interfaces.action import Turn
from nav2_msgs.action import FollowWaypoints

from action_servers.core.maneuver import ZERO
from action_servers.robot_io.adapter import SHOWN_CHARACTERS, shown


def test_a_goal_is_shown_in_one_line():
    """Every field with its value."""
    assert shown(Turn.Goal(angle=90.0)) == "angle=90.0, angular_velocity=0.0"
    assert shown(Turn.Goal(angle=0.2)) == "angle=0.2, angular_velocity=0.0"


def test_a_long_goal_is_cut(pose):
    """A hundred waypoints do not fill the log."""
    text = shown(FollowWaypoints.Goal(poses=[pose(1.0, 2.0)] * 100))
    assert len(text) == SHOWN_CHARACTERS + 3
    assert text.endswith("...")


def test_a_check_that_raises_rejects_the_goal_and_not_the_server(bench, monkeypatch):
    """Whatever a goal holds."""

    def broken(*_: Any, **__: Any) -> None:
        raise IndexError("list index out of range")

    with monkeypatch.context() as patch:
        patch.setattr("action_servers.core.action.faults", broken)
        bad = bench.send("turn")
        bench.steps(2)
    assert bad.accepted is False
    assert bench.commands == []
    sound = bench.send("turn")
    bench.steps(2)
    assert sound.accepted is True


def test_a_preparation_that_raises_ends_the_goal_and_not_the_server(bench, monkeypatch):
    """It has been accepted by then, so it is aborted with the cause; the robot does not move."""

    def broken(*_: Any) -> None:
        raise OSError("no more file handles")

    with monkeypatch.context() as patch:
        patch.setattr(bench.servers._sensors, "localization", broken)
        bad = bench.send("navigate_to_pose")
        bench.steps(2)
    assert (bad.accepted, bad.status) == (True, "aborted")
    assert bad.result.error_msg == "OSError: no more file handles"
    assert set(bench.commands) <= {ZERO}
    sound = bench.send("navigate_to_pose")
    bench.steps(5)
    assert (sound.accepted, sound.status) == (True, None)
