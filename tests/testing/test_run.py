"""A mission under test is moved on, acted on and asked, all in virtual time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.testing.run import NeverHeldError

WAITS = """
mission: waits
inputs: {pause: 0.5}
tree:
  sequence:
    - wait: $pause
      name: first
    - set: {done: 1}
    - log: half done
    - wait: 1
      name: second
"""
DRIVE = """
mission: drive
world: empty_arena
tree:
  sequence:
    - explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.5}
      timeout: 60
    - turn: {angle: 90}
      timeout: 60
"""


def test_a_run_goes_from_control_step_to_control_step(stage: Any) -> None:
    """At 20 Hz, from the start to the end; each is a moment to ask about."""
    run = stage.run(WAITS)
    assert [run.step().t for _ in range(3)] == [0.05, 0.1, 0.15]
    assert run.now.leaf("first").running
    assert run.advance(0.4).t == 0.55
    assert run.now.leaf("first").succeeded
    run.until_done()
    assert run.succeeded
    assert (run.t, len(run.moments)) == (1.55, 31)
    assert [m.t for m in run.moments if "second" in m.running][:1] == [0.55]


def test_a_run_can_be_asked_about_any_of_its_moments(stage: Any) -> None:
    """RunVariables, log, leaves, as they were then."""
    run = stage.run(WAITS, inputs={"pause": 0.2}, seed=9)
    run.until_done()
    before, after = run.moments[3], run.moments[4]
    assert (before.t, after.t) == (0.2, 0.25)
    assert (dict(before.variables), dict(after.variables)) == (
        {"pause": 0.2},
        {"pause": 0.2, "done": 1},
    )
    assert (before.log, after.log) == ([], ["half done"])
    assert (before.leaf("second").status, after.leaf("second").status) == ("idle", "running")
    assert (after.leaf("first").since, after.leaf("first").runs) == (0.25, 1)
    assert after.tree.splitlines()[1] == "  ✓ first  0.0 s left"
    assert run.mission.seed == 9


def test_what_is_done_at_a_time_and_on_a_condition(stage: Any) -> None:
    """Each once; at a time that is no control step, too."""
    run = stage.run(WAITS)
    done: list[Any] = []
    run.at(0.33, lambda r: done.append(("at", r.t)))
    run.at(0.33, lambda r: done.append(("then", r.t)))
    run.at(0.1, lambda r: done.append(("early", r.t)))
    run.when(lambda s: s.leaf("second").running, lambda r: done.append(("when", r.t)))
    run.until_done()
    assert done == [("early", 0.1), ("at", 0.33), ("then", 0.33), ("when", 0.55)]
    with pytest.raises(ScenarioError, match=r"0.3 s is in the past: the run is at 1.55 s"):
        run.at(0.3, print)


def test_what_an_action_raises_comes_out(stage: Any) -> None:
    """It is the test's mistake, and not a failure of the mission."""
    run = stage.run(WAITS)

    def wrong(_run: Any) -> None:
        raise KeyError("oh")

    run.at(0.2, wrong)
    with pytest.raises(KeyError, match="oh"):
        run.until_done()
    assert run.t == 0.2
    run.until_done()
    assert run.succeeded


def test_until_stops_where_its_condition_holds_first(stage: Any) -> None:
    """And says in the end how the tree stood when it never did."""
    run = stage.run(WAITS)
    assert run.until(lambda s: s.log).t == 0.55
    with pytest.raises(NeverHeldError) as caught:
        run.until(lambda s: s.t > 100, within=0.2)
    assert str(caught.value) == (
        "the condition did not hold within 0.2 s; at 0.75 s:\n"
        "▶ waits\n  ✓ first  0.0 s left\n  ✓ set done  done = 1\n  ✓ log  half done\n  ▶ second"
    )
    with pytest.raises(NeverHeldError, match="the mission ended before the condition held: succ"):
        run.until(lambda s: False)
    with pytest.raises(ScenarioError, match="the mission has ended: success"):
        run.step()


def test_a_mission_that_does_not_end_has_a_bound(stage: Any) -> None:
    """The tree is shown."""
    run = stage.run("mission: m\ntree: {wait: 1000}\n")
    with pytest.raises(NeverHeldError, match=r"(?s)did not end within 5 s; at 5.00 s:\n▶ wait"):
        run.until_done(within=5)


def test_the_robot_and_its_goals(stage: Any) -> None:
    """The truth about the robot, and the lives of its goals."""
    run = stage.run(DRIVE, seed=1)
    turning = run.until(lambda s: s.leaf("turn").running)
    assert turning.open_goals == ("/turn",)
    run.until_done()
    drive, turn = run.goals
    assert turning.goals == (drive, turn)
    assert (drive.action, drive.status, turn.status) == (
        "/explore_forward",
        "succeeded",
        "succeeded",
    )
    assert [event.change for _, event in turn.changes] == ["sent", "ended"]
    assert drive.ended_s is not None
    assert drive.ended_s <= turn.sent_s
    assert run.now.pose[2] == pytest.approx(1.571, abs=0.05)
    assert run.now.distance == pytest.approx(run.now.x - run.moments[0].x, abs=0.02)
    assert run.moments[40].speed == pytest.approx(0.2, abs=0.01)
    assert run.moments[40].commanded == (pytest.approx(0.2), 0)
    assert run.now.odometry[2] == pytest.approx(1.571, abs=0.05)
    assert run.now.collisions == 0


def test_topics_are_recorded_when_asked_for(stage: Any) -> None:
    """At the rate at which they come; any of the graph."""
    run = stage.run(WAITS)
    run.record("scan", "/odom", "scan")
    run.advance(1.0)
    assert run.topic("odom").times[:2] == (0.0, 0.05)
    assert len(run.topic("scan")) == len(run.topic("scan").messages) > 3
    assert run.now.scan is run.topic("/scan").last
    assert len(run.moments[0].scan.ranges) == 360
    with pytest.raises(ScenarioError, match=r"unknown topic '/scam' .*mean '/scan'"):
        run.record("scam")
    with pytest.raises(ScenarioError, match="/imu is not recorded, but /scan, /odom: call"):
        run.now.topic("imu")


def test_nodes_are_named_by_name_or_path(stage: Any) -> None:
    """A name that several have is refused, with their paths."""
    run = stage.run("mission: m\ntree: {sequence: [{wait: 1}, {wait: 2}, {log: x}]}")
    run.step()
    assert run.leaf("0.1").status == "idle"
    assert repr(run.leaf("0.0")) == "<wait: running since 0.05 s>"
    with pytest.raises(ScenarioError, match=r"several .* use a path, '0.0', '0.1'"):
        run.leaf("wait")
    with pytest.raises(ScenarioError, match="unknown node 'lag'"):
        run.leaf("lag")


def test_missions_of_every_source(stage: Any, mission: Any, world: Any, tmp_path: Any) -> None:
    """A text, a file, a shipped one's name; faults come out with their places."""
    path = tmp_path / "m.yaml"
    path.write_text(WAITS)
    for source in (path, str(path), WAITS):
        assert mission(source).name == "waits"
    assert mission("explore").name == "explore"
    with pytest.raises(InputError, match=r"<text>:2:14: error: expected seconds, 0 or more"):
        stage.run("mission: m\ntree: {wait: -1}\n")
    with pytest.raises(ScenarioError, match="robot: give the mission as file or text"):
        stage.run(mission(WAITS), robot="burger")
    run = stage.run(mission(WAITS), seed=3)
    assert run.mission.seed == 3
    run.step()
    small = world("name: small\nsize: [2, 2]\n")
    assert str(small).endswith("world_1.yaml")


def test_one_run_after_the_other(stage: Any) -> None:
    """A second while the first goes on is refused; the first can still be asked about."""
    first = stage.run(WAITS)
    first.step()
    with pytest.raises(ScenarioError, match="'waits' is still on the stage: call"):
        stage.run(WAITS)
    first.until_done()
    second = stage.run(WAITS)
    second.until_done()
    assert first.stage.trace.sha256 == second.stage.trace.sha256
    assert first.moments[5].leaf("first").running


@pytest.mark.parametrize("pauses", [False, True])
def test_an_ended_test_leaves_nothing_running(stage: Any, *, pauses: bool) -> None:
    """The drive is cancelled, its end confirmed, and known when; also in a pause."""
    run = stage.run(DRIVE)
    run.until(lambda s: s.speed > 0.1)
    if pauses:
        run.stage.executive.pause("later", keep_goals=True)
    ended_s = run.t
    assert run.close() == ()
    assert run.stopped_s == ended_s
    assert (run.status, run.reason) == ("interrupted", "its time is up")
    assert run.goals[0].status == "canceled"
    assert run.close() == ()


def test_a_scripted_server_stands_in_for_ours(stage: Any, scripted_server: Any) -> None:
    """The test plays the turn; the drive is ours."""
    turn = scripted_server("turn", accepts=None)
    run = stage.run(DRIVE, seed=1)
    run.until(lambda s: turn.goals)
    turn.goal.accept()
    run.advance(1.0)
    turn.goal.abort(error_code=906, error_msg="stuck")
    run.until_done()
    assert run.failed
    assert run.leaf("turn").outcome == "aborted: /turn: stuck (code 906)"
    with pytest.raises(ScenarioError, match="unknown short name of an action 'dock'"):
        scripted_server("dock")


def test_a_scenario_keeps_its_simulator(stage: Any, tmp_path: Path) -> None:
    """It does not run in MuJoCo because a test runs it."""
    path = tmp_path / "s.scenario.yaml"
    mission = "mission: {mission: turns, world: nav_arena, tree: {turn: {angle: 9}, timeout: 9}}\n"
    path.write_text(f"scenario: s\n{mission}simulator: sim.ir_sim:IrSim\n", encoding="utf-8")
    assert stage.run_scenario(path).passed
    assert stage.runs[-1].options.simulator is not None


def test_a_wrong_input_is_named_as_an_argument(stage: Any) -> None:
    """No option of a command was given."""
    with pytest.raises(InputError) as caught:
        stage.run(WAITS, inputs={"pauses": 1})
    assert str(caught.value).startswith("inputs: error: unknown input 'pauses' (the mission's")
