"""Planned faults on the stage: when they begin, and what becomes of them."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.scenarios.faults.plan import FaultPlan

TURNS = """\
mission: turns
world: empty_arena
tree:
  sequence:
    - turn: {angle: 90}
    - turn: {angle: -90}
      name: back
"""


def planned(stage: Any, *texts: str, mission: str = TURNS) -> tuple[Any, FaultPlan]:
    """Return a run with planned faults."""
    run = stage.run(mission)
    return run, stage.plan(run, *texts)


def test_a_planned_fault_is_that_of_a_test(stage: Any) -> None:
    """The trace is the same to the last byte."""
    run = stage.run(TURNS)
    run.at(0.5, stage.faults.drop("odom", share=0.5, lasting=1))
    run.until_done()
    other, plan = planned(stage, "at 0.5: drop odom share 0.5 lasting 1")
    other.until_done()
    assert other.report.trace_sha256 == run.report.trace_sha256
    assert [str(outcome) for outcome in plan.outcomes()] == [
        "at 0.5: drop odom share 0.5 lasting 1: from 0.50 s to 1.50 s"
    ]


def test_after_a_step_is_where_a_test_acts_between_steps(stage: Any) -> None:
    """Such as after `run.advance`."""
    run = stage.run(TURNS)
    run.advance(0.5)
    run.do(stage.faults.kill_server("turn", lasting=1))
    run.until_done()
    other, _ = planned(stage, "after 0.5: kill_server turn lasting 1")
    other.until_done()
    assert other.report.trace_sha256 == run.report.trace_sha256


def test_a_condition_is_looked_at_after_each_control_step(stage: Any) -> None:
    """As that of `run.when` is; the fault happens once."""
    run = stage.run(TURNS)
    run.when(lambda s: s.leaf("back").running, stage.faults.shove(turn=1.0))
    run.until_done()
    other, plan = planned(stage, 'when running("back"): shove turn 1.0')
    other.until_done()
    assert other.report.trace_sha256 == run.report.trace_sha256
    (outcome,) = plan.outcomes()
    assert outcome.began == outcome.ended == run.faults[0].began_s


def test_a_condition_has_to_hold_for_its_time(stage: Any) -> None:
    """From the step at which it came true."""
    run, plan = planned(
        stage, 'when running("back"): imu_dead', 'when running("back") for 0.3 s: imu_dead'
    )
    run.until_done()
    first, second = plan.outcomes()
    assert first.began is not None
    assert second.began == pytest.approx(first.began + 0.3)


def test_what_never_happens_says_why(stage: Any) -> None:
    """Past the end, or on a condition that never came true."""
    run, plan = planned(
        stage,
        "at 60: imu_dead may_not_happen",
        "when collisions > 0: imu_dead may_not_happen",
    )
    end = run.until_done().virtual_s
    assert [outcome.why for outcome in plan.outcomes()] == [
        f"the mission ended at {end:.2f} s",
        f"its condition was not true by the end at {end:.2f} s",
    ]
    assert all(outcome.began is None for outcome in plan.outcomes())


def test_names_that_are_not_there_are_found_before_the_start(stage: Any) -> None:
    """Each with the part of the text that is wrong."""
    run, plan = planned(
        stage,
        "at 1: drop scna may_not_happen",
        "at 1: kill_server trun may_not_happen",
        "at 1: drop scan receiver nobody may_not_happen",
        "at 1: ignore_service sto may_not_happen",
        "at 1: raise_in_leaf bak may_not_happen",
        'when speed > 0 and running("bak"): imu_dead may_not_happen',
        "at 1: kill_server /turn may_not_happen",
    )
    run.step()
    problems = list(plan.problems())
    assert [(problem.number, problem.part, problem.offset) for problem in problems] == [
        (0, "scna", 0),
        (1, "trun", 0),
        (2, "nobody", 0),
        (3, "sto", 0),
        (4, "bak", 0),
        (5, 'speed > 0 and running("bak")', 14),
    ]
    assert problems[0].message.endswith("did you mean '/scan'?")
    assert problems[5].message.startswith("unknown node: 'bak'")


def test_a_part_that_the_robot_has_not_is_found_before_the_start(stage: Any) -> None:
    """It cannot break, so the run does not say that it did."""
    mission = TURNS.replace("tree:", "robot: burger\ntree:", 1)
    faults = ("at 1: imu_dead", "at 1: camera_dead lasting 1")
    run, plan = planned(stage, *(f"{each} may_not_happen" for each in faults), mission=mission)
    run.step()
    (problem,) = plan.problems()
    assert (problem.number, problem.part) == (1, "camera_dead")
    assert problem.message == "a burger has no camera"


def test_looking_for_names_changes_nothing(stage: Any) -> None:
    """Not even of actions that are offered only when somebody asks for them."""
    run, plan = planned(stage, "at 100: kill_server spin may_not_happen")
    assert list(plan.problems()) == []
    other = stage.mission(TURNS)
    assert other.name == run.mission.name
    assert "spin" not in " ".join(run.stage.servers.actions)
    run.step()


def test_a_fault_that_cannot_begin_is_an_error_of_the_test(stage: Any) -> None:
    """As in a test that makes it itself."""
    run, _ = planned(stage, "at 0.5: move_box chair ahead 1 may_not_happen")
    with pytest.raises(ScenarioError, match="unknown spawned obstacle 'chair'"):
        run.until_done()
