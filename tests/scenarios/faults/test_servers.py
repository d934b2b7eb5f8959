"""Faults of servers themselves: aborted goals, death and return, exceptions in code, services."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.executive.goals.goal import FORGOTTEN
from bt_mission.scenarios.faults.errors import ScenarioError
from tests.support.faulty_runs import outcome

SERVICE = """
mission: m
world: empty_arena
tree:
  fallback:
    - service: {name: /reset_odometry, type: std_srvs/srv/Trigger}
      timeout: 2
      name: call
    - wait: 0.5
"""


# ---- aborted goals -----------------------------------------------------------------------


def test_a_goal_is_aborted(stage: Any, turn: Any) -> None:
    """At its next control step, with code and message; the robot is stopped."""
    run = turn(timeout=5)
    run.at(1.0, stage.faults.abort_goal("turn", 906, "stuck"))
    assert outcome(run) == (1.0, "aborted: /turn: stuck (code 906)")
    run.until_done()
    assert run.check("whenever time >= 1.5: abs(turn_rate) < 0.01")
    assert [goal.status for goal in run.goals] == ["aborted"]


def test_a_goal_is_aborted_at_its_progress(stage: Any, turn: Any) -> None:
    """The next goal, too, where none runs yet; once."""
    run = turn(timeout=5)
    run.do(stage.faults.abort_goal("turn", message="dizzy", when=lambda f: f.current_angle > 45))
    assert outcome(run) == (1.05, "aborted: /turn: dizzy")
    assert run.now.yaw == pytest.approx(0.86, abs=0.02)
    assert run.faults[0].ended_ns == 2_050_000_000


def test_a_goal_that_the_test_plays_is_aborted(stage: Any, scripted_server: Any) -> None:
    """By its server; there is none before the goal has come."""
    scripted_server("turn")
    run = stage.run("mission: m\ntree: {turn: {angle: 90}, timeout: 5}\n")
    abort = stage.faults.abort_goal("turn", 906, "stuck")
    with pytest.raises(ScenarioError, match="abort_goal: /turn has no goal yet"):
        run.do(abort)
    with pytest.raises(ScenarioError, match="is played by the test, which says when"):
        run.do(stage.faults.abort_goal("turn", when=lambda f: True))
    run.at(0.5, abort)
    assert outcome(run) == (0.5, "aborted: /turn: stuck (code 906)")
    assert str(run.faults[0]).endswith(" at 0.50 s")


def test_a_progress_that_raises_is_the_tests_mistake(stage: Any, turn: Any) -> None:
    """The mission is not blamed."""
    run = turn(timeout=5)
    run.do(stage.faults.abort_goal("turn", when=lambda f: f.angle > 3))
    with pytest.raises(ScenarioError, match="`when` raised AttributeError: "):
        run.until_done()
    run.do(stage.faults.clear)
    run.until_done()
    assert run.succeeded


# ---- death and return --------------------------------------------------------------------


def test_a_server_dies(stage: Any, turn: Any) -> None:
    """It is missed in time, the base stops by itself; the goal is named, as nobody ended it."""
    run = turn(timeout=5)
    run.at(1.0, stage.faults.kill_server("turn"))
    assert outcome(run) == (1.1, "server lost: /turn has gone from the graph")
    run.until_done()
    assert run.check("always between 0.6 s and 1.1 s turn_rate > 0.9")
    assert run.check("whenever time >= 1.5: abs(turn_rate) < 0.01")
    assert run.reason.startswith("orphaned goals: /turn goal")
    assert len(run.close()) == 1


def test_a_server_that_returns_knows_nothing(stage: Any, turn: Any) -> None:
    """It says so when it is asked to cancel, so no goal is left behind."""
    run = turn(timeout=5)
    run.at(1.0, stage.faults.kill_server("turn", lasting=0.5))
    run.until_done()
    assert run.succeeded
    assert str(run.goals[0]).endswith("released at 1.10 s, ended at 2.15 s): unknown")


def test_a_server_that_returns_before_it_is_missed(stage: Any, turn: Any) -> None:
    """The leaf learns at its limit that the goal is no more."""
    run = turn(timeout=1.5)
    run.at(1.12, stage.faults.kill_server("turn", lasting=0.1))
    assert outcome(run) == (
        1.65,
        f"server lost: /turn {FORGOTTEN}",
    )
    run.until_done()
    assert run.succeeded


def test_a_retry_outlives_a_restart(stage: Any) -> None:
    """The second attempt waits for the new server, and is served by it."""
    run = stage.run(
        "mission: m\nworld: empty_arena\n"
        "tree: {retry: {attempts: 2, pause: 0}, do: {turn: {angle: 90}, timeout: 5}}\n"
    )
    run.at(1.0, stage.faults.kill_server("turn", lasting=1.0))
    run.until_done()
    assert run.succeeded
    assert [goal.status for goal in run.goals] == ["unknown", "succeeded"]


def test_a_server_that_the_test_plays_dies_and_returns(stage: Any, scripted_server: Any) -> None:
    """Under the same name; it has forgotten its goals, and the test goes on playing it."""
    server = scripted_server("turn")
    run = stage.run(
        "mission: m\ntree: {retry: {attempts: 2, pause: 0}, do: {turn: {angle: 9}, timeout: 5}}\n"
    )
    run.at(0.5, stage.faults.kill_server("turn", lasting=0.5))
    run.until(lambda s: len(server.goals) == 2)
    server.goal.succeed()
    run.until_done()
    assert run.succeeded
    assert [goal.status for goal in run.goals] == ["unknown", "succeeded"]


def test_a_dead_server_offers_nothing(stage: Any, turn: Any) -> None:
    """Other faults of it are errors; runs with a death repeat, and leave nothing behind."""
    hashes = []
    for _ in range(2):
        run = turn(timeout=5)
        run.at(0.5, stage.faults.kill_server("turn", lasting=1.0))
        run.advance(1.0)
        with pytest.raises(ScenarioError, match="unknown action '/turn'"):
            run.do(stage.faults.reject_goals("turn"))
        run.until_done()
        hashes.append(run.stage.trace.sha256)
    assert hashes[0] == hashes[1]


# ---- exceptions --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("method", "on", "ended"), [("step", 1, 1.0), ("step", 3, 1.1), ("feedback", 1, 1.0)]
)
def test_an_exception_in_a_maneuver(
    stage: Any, turn: Any, method: str, on: int, ended: float
) -> None:
    """Ends its goal with the cause; the robot is stopped, and the server serves the next."""
    run = turn(timeout=5)
    run.at(1.0, stage.faults.raise_in_maneuver("turn", KeyError("no"), method=method, on=on))
    assert outcome(run) == (ended, "aborted: /turn: KeyError: 'no' (code 900)")
    run.until_done()
    assert run.check(f"whenever time >= {ended + 0.6}: abs(turn_rate) < 0.01")
    run = turn(timeout=5)
    assert outcome(run) == (1.95, "success")


def test_an_exception_in_a_result(stage: Any, turn: Any) -> None:
    """What was a success is none."""
    run = turn(timeout=5)
    run.do(stage.faults.raise_in_maneuver("turn", method="result"))
    assert outcome(run) == (1.95, "aborted: /turn: RuntimeError: made by a fault (code 900)")


def test_only_our_own_servers_have_maneuvers(stage: Any, scripted_server: Any) -> None:
    """Those that are there stand in the error."""
    scripted_server("turn", may_not_be_asked=True)
    run = stage.run("mission: m\ntree: {wait: 1}\n")
    with pytest.raises(ScenarioError, match="unknown shipped action '/turn'"):
        run.do(stage.faults.raise_in_maneuver("turn"))
    run.step()


def test_a_fault_may_name_an_action_that_the_mission_does_not_use(stage: Any) -> None:
    """Of the actions of ours, those of the mission are offered at first, and others when named."""
    run = stage.run("mission: m\nworld: empty_arena\ntree: {turn: {angle: 9}, timeout: 9}\n")
    assert run.stage.servers.actions == ("/turn",)
    run.do(stage.faults.raise_in_maneuver("spin"), stage.faults.slow_server("move", 1.0))
    assert "/spin" in run.stage.servers.actions
    run.do(stage.faults.kill_server("turn", lasting=0.1))
    run.until_done(within=20)
    assert "/spin" in run.stage.servers.actions
    with pytest.raises(ScenarioError, match="unknown action '/tern'"):
        run.do(stage.faults.kill_server("tern"))


# ---- services ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "ended", "output"),
    [
        (lambda f: f.delay_service("reset_odometry", 0.4), 0.45, "odometry is (0, 0, 0) here"),
        (lambda f: f.ignore_service("reset_odometry"), 2.05, "no answer"),
        (lambda f: f.fail_service("reset_odometry", success=False, message="worn"), 0.1, "worn"),
    ],
)
def test_a_service(stage: Any, make: Any, ended: float, output: str) -> None:
    """Late, never, and with an answer in its place."""
    run = stage.run(SERVICE)
    run.do(make(stage.faults))
    result = outcome(run, "call")
    assert result[0] == ended
    assert output in result[1]


def test_services_and_fields_that_are_not_there(stage: Any) -> None:
    """Those that are stand in the error."""
    run = stage.run(SERVICE)
    with pytest.raises(ScenarioError, match=r"unknown service '/stap'"):
        run.do(stage.faults.ignore_service("stap"))
    with pytest.raises(ScenarioError, match=r"fail_service: /stop: .*'sucess'.*success"):
        run.do(stage.faults.fail_service("stop", sucess=False))
    run.step()


@pytest.mark.parametrize(
    ("leaf", "method", "on", "ended"),
    [
        ("turn", "update", 1, 1.0),
        ("turn", "update", 3, 1.1),
        ("0.0", "terminate", 1, 1.95),
        ("turn", "initialise", 1, None),
    ],
)
def test_an_exception_in_a_leaf(
    stage: Any, turn: Any, leaf: str, method: str, on: int, ended: float | None
) -> None:
    """Ends the mission with the cause; the goal is cancelled, the end confirmed."""
    run = turn(timeout=5)
    fault = stage.faults.raise_in_leaf(leaf, ValueError("oh"), method=method, on=on)
    if ended is None:
        run.do(fault)
    else:
        run.at(1.0, fault)
    run.until_done()
    assert run.failed
    assert run.reason.startswith("ValueError: oh (servers.py:")
    assert [goal.status for goal in run.goals] == (
        [] if ended is None else ["succeeded" if ended == 1.95 else "canceled"]
    )
    if ended is not None:
        assert run.t == pytest.approx(ended + 0.05, abs=0.051)
        assert run.now.commanded[1] == 0 or run.t < 2
    assert run.close() == ()


def test_a_leaf_is_sound_after_the_fault(stage: Any, turn: Any) -> None:
    """It raises once, or not at all when the fault has ended before."""
    run = turn(timeout=5)
    run.do(stage.faults.raise_in_leaf("turn", on=50, lasting=1.0))
    run.until_done()
    assert run.succeeded
    assert run.find("turn").call_hooks == ()


def test_an_exception_in_a_callback(stage: Any, turn: Any) -> None:
    """Of a topic or a service of a node: the mission fails with the cause, the robot is stopped."""
    run = turn(timeout=5)
    run.at(1.0, stage.faults.raise_in_callback("bt_mission_servers", "scan", on=2))
    run.until_done()
    assert (run.failed, run.t) == (True, 1.1)
    assert run.reason.startswith("a callback failed: RuntimeError: made by a fault (")
    assert [goal.status for goal in run.goals] == ["canceled"]
    run = stage.run("mission: m\ntree: {service: {name: /stop, type: std_srvs/srv/Trigger}}\n")
    run.do(stage.faults.raise_in_callback("/bt_mission_servers", "stop", OSError("disk")))
    run.until_done()
    assert run.reason.startswith("a callback failed: OSError: disk")


def test_leaves_and_callbacks_that_are_not_there(stage: Any, turn: Any) -> None:
    """What is stands in the error."""
    run = turn(timeout=5)
    faults = stage.faults
    for fault, reason in (
        (faults.raise_in_leaf("tern"), "unknown node 'tern'"),
        (faults.raise_in_leaf("turns"), "unknown leaf 'turns'"),
        (faults.raise_in_callback("sim", "scan"), "unknown node '/sim'"),
        (
            faults.raise_in_callback("bt_mission_sim", "scan"),
            "unknown topic or service of /bt_mission_sim '/scan'",
        ),
    ):
        with pytest.raises(ScenarioError, match=reason):
            run.do(fault)
    run.step()
