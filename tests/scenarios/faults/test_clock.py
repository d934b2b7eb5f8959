"""A clock that jumps, or stands still: what the executive and the servers make of it."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.scenarios.faults.errors import ScenarioError
from tests.support.thorough import sample

WAIT = """
mission: waits
world: empty_arena
tree: {wait: 3, name: pause}
"""


def jumps(run: Any) -> list[float]:
    """The jumps that the executive has seen, s."""
    return [event["jump"] for event in run.events("clock")]


# ---- the effect --------------------------------------------------------------------------


def test_the_executives_clock_jumps_and_no_other(stage: Any) -> None:
    """By so much, at once, and back at the end of the fault."""
    run = stage.run(WAIT)
    run.at(1.0, stage.faults.jump_clock(0.5, lasting=1.0))
    nodes = run.stage.node, run.stage.servers

    def ahead_s() -> float:
        mine, its = (node.get_clock().now().nanoseconds for node in nodes)
        return (mine - its) / 1e9

    seen = [ahead_s()]
    for time in (1.5, 2.5):
        run.until(lambda s, time=time: s.t >= time)
        seen.append(ahead_s())
    assert seen == [0.0, 0.5, 0.0]


def test_a_clock_does_not_go_below_zero(stage: Any) -> None:
    """It starts at zero, as that of a simulator that is started anew."""
    run = stage.run(WAIT)
    run.at(1.0, stage.faults.jump_clock(-50.0))
    run.until(lambda s: s.t >= 1.5)
    assert run.stage.node.get_clock().now().nanoseconds == 500_000_000
    assert [event["what"] for event in run.events("fault")] == ["jump_clock"]
    assert jumps(run) == [-1.9]


def test_a_clock_stands_still(stage: Any) -> None:
    """And goes on from there."""
    run = stage.run(WAIT)
    run.at(1.0, stage.faults.stop_clock(lasting=5.0))
    run.until(lambda s: s.t >= 5.5)
    assert run.stage.node.get_clock().now().nanoseconds == 2_050_000_000
    run.until_done()
    assert (run.succeeded, run.t, jumps(run)) == (True, 8.05, [])


def test_what_is_not_there_is_listed(stage: Any) -> None:
    """A node of another name."""
    run = stage.run(WAIT)
    with pytest.raises(ScenarioError, match="/bt_mission_servers"):
        run.do(stage.faults.jump_clock(1.0, node="nobody"))
    run.step()


# ---- the mission's answer ----------------------------------------------------------------


@pytest.mark.parametrize(("at", "by", "ends"), [(2.0, -1.5, 3.15), (1.0, 100.0, 1.0)])
def test_a_wait_lasts_its_time_on_the_clock(stage: Any, at: float, by: float, ends: float) -> None:
    """Nobody waits longer for a clock that is set back; one that skips has let the time pass."""
    run = stage.run(WAIT)
    run.at(at, stage.faults.jump_clock(by))
    run.until_done(within=5)
    assert (run.succeeded, run.t) == (True, ends)


def test_a_goal_times_out_when_the_clock_skips_and_is_confirmed_as_ended(
    stage: Any, turn: Any
) -> None:
    """Limits are in ROS time; nothing is left behind."""
    run = turn(timeout=20)
    run.at(1.0, stage.faults.jump_clock(100.0))
    run.until_done()
    assert run.leaf("turn").outcome == "canceled by timeout: not done within 20 s"
    assert [goal.status for goal in run.goals] == ["canceled"]
    assert (run.report.goals_left_behind, jumps(run)) == (0, [100.05])


def test_a_goal_is_kept_when_the_clock_is_set_back(stage: Any, turn: Any) -> None:
    """It succeeds as if nothing had happened."""
    run = turn(timeout=5)
    run.at(1.0, stage.faults.jump_clock(-10.0))
    run.until_done()
    assert [goal.status for goal in run.goals] == ["succeeded"]
    assert run.succeeded


@pytest.mark.parametrize("at", sample([0.5, 2.0, 2.9, 3.1], 4))
def test_no_limit_waits_for_the_time_before_a_reset_once_more(
    stage: Any, scripted_server: Any, at: float
) -> None:
    """Of a goal that never ends and confirms no cancel, whenever the clock is set back."""
    server = scripted_server("turn", cancels=False)
    run = stage.run("mission: m\ntree: {turn: {angle: 90}, timeout: 3}\n")
    run.at(at, stage.faults.jump_clock(-100.0))
    run.until(lambda s: s.leaf("turn").failed, within=7)
    assert run.leaf("turn").outcome.startswith("cancel refused")
    server.goal.succeed()
    run.until_done(within=8)
    assert run.report.goals_left_behind == 0


def test_servers_end_their_goals_when_their_clock_is_set_back(stage: Any, turn: Any) -> None:
    """What is done for a time would be done for longer; the base stops at once."""
    run = turn(timeout=5)
    run.at(1.0, stage.faults.jump_clock(-1.0, node="bt_mission_servers"))
    run.until(lambda s: s.leaf("turn").failed)
    assert run.leaf("turn").outcome == (
        "aborted: /turn: the ROS clock was set back by 0.90 s (code 901)"
    )
    run.until_done()
    assert run.check("whenever time >= 1.5: abs(turn_rate) < 0.01")
