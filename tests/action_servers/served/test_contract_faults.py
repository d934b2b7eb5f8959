"""What every action server keeps to: exceptions, silent sensors, and the end of the servers."""

from __future__ import annotations

from typing import Any

import pytest

from action_servers.camera_sweep import CameraSweep
from action_servers.explore_forward import ExploreForward
from action_servers.maneuver import ZERO, ErrorCode
from action_servers.navigation.navigate import NavigateToPose
from action_servers.navigation.waypoints import FollowWaypoints
from action_servers.turn import Turn

MANEUVERS: dict[str, Any] = {
    "explore_forward": ExploreForward,
    "turn": Turn,
    "camera_sweep": CameraSweep,
    "navigate_to_pose": NavigateToPose,
    "follow_waypoints": FollowWaypoints,
}


@pytest.mark.parametrize("method", ["step", "feedback"])
def test_a_maneuver_that_raises_ends_its_goal_and_not_the_server(bench, name, method, monkeypatch):
    """Aborted with the cause, the robot stopped, the next goal as usual."""
    sent = bench.send(name)
    bench.until(lambda: bench.moved)
    bench.steps(5)

    def broken(*_: Any) -> None:
        raise KeyError("no such sensor")

    with monkeypatch.context() as patch:
        patch.setattr(MANEUVERS[name], method, broken)
        bench.steps(2)
    assert sent.status == "aborted"
    assert sent.result.error_code == ErrorCode.UNKNOWN
    assert sent.result.error_msg == "KeyError: 'no such sensor'"
    assert bench.before_the_last_end == ZERO

    following = bench.send(name)
    bench.steps(20)
    assert (following.accepted, following.status) == (True, None)
    assert bench.commands[-1] != ZERO


def test_a_result_that_raises_still_ends_the_goal(bench, name, monkeypatch):
    """The client is not left waiting."""
    sent = bench.send(name)
    bench.steps(5)

    def broken(*_: Any) -> None:
        raise KeyError("no such sensor")

    with monkeypatch.context() as patch:
        patch.setattr(MANEUVERS[name], "result", broken)
        bench.cancel(name, sent.id)
        bench.steps(1)
    assert sent.status == "canceled"


@pytest.mark.parametrize("method", ["feedback", "result"])
def test_fields_that_do_not_exist_end_the_goal_and_not_the_server(bench, goal, method, monkeypatch):
    """The reason lists the fields that there are."""
    with monkeypatch.context() as patch:
        patch.setattr(Turn, method, lambda *_: {"angel": 1.0})
        sent = bench.send("turn", goal("turn", angle=5.0))
        bench.until(lambda: sent.status is not None)
    assert sent.status == "aborted"
    assert sent.result.error_code == ErrorCode.UNKNOWN
    assert "has no field 'angel', only" in sent.result.error_msg


@pytest.mark.parametrize("lost", ["scan", "odom"])
def test_a_sensor_that_falls_silent_ends_the_goal(bench, name, lost):
    """Within five seconds, aborted with a code and a reason, and the robot stands."""
    sent = bench.send(name)
    bench.until(lambda: bench.moved)
    bench.robot.silent = {lost}
    bench.until(lambda: sent.status is not None, limit=100)
    assert sent.status == "aborted"
    assert sent.result.error_code != 0
    assert sent.result.error_msg != ""
    assert bench.before_the_last_end == ZERO


def test_stopping_the_servers_ends_the_goal_with_the_robot_stopped(bench, name):
    """And nothing is accepted any more."""
    sent = bench.send(name)
    bench.until(lambda: bench.moved)
    bench.servers.stop("the action servers were stopped by SIGTERM")
    bench.clock.run_until_quiet()
    assert sent.status == "aborted"
    assert sent.result.error_msg == "the action servers were stopped by SIGTERM"
    assert bench.commands[-1] == ZERO
    late = bench.send(name)
    bench.steps(5)
    assert late.accepted is False
    assert bench.commands[-1] == ZERO


def test_destroying_the_node_stops_the_robot(bench, name):
    """Even when nobody waits for a result."""
    bench.send(name)
    bench.until(lambda: bench.moved)
    bench.servers.destroy_node()
    bench.clock.remove_node(bench.servers)
    bench.steps(1)
    assert bench.commands[-1] == ZERO
