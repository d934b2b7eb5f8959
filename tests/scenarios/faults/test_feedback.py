"""Faults of feedback, and what a mission answers: its conditions, its limit of silence."""

from __future__ import annotations

import math
from typing import Any

import pytest

from bt_mission.scenarios.faults.errors import ScenarioError
from tests.support.faulty_runs import outcome


@pytest.mark.parametrize(
    "make",
    [
        lambda f: f.silence_feedback("turn"),
        lambda f: f.delay_feedback("turn", 1.0),
        lambda f: f.forge_feedback("turn", instead=True),
    ],
)
def test_feedback_that_does_not_come(stage: Any, turn: Any, make: Any) -> None:
    """Is silence, which a limit ends; feedback of another goal is none. The robot is stopped."""
    run = turn(timeout=5, feedback_timeout=0.5)
    run.at(0.6, make(stage.faults))
    assert outcome(run) == (1.1, "feedback silent for too long: no feedback for 0.5 s")
    run.until_done()
    assert [goal.status for goal in run.goals] == ["canceled"]
    assert run.check("whenever time >= 1.6: abs(turn_rate) < 0.01")


@pytest.mark.parametrize(
    "make",
    [
        lambda f: f.silence_feedback("turn"),
        lambda f: f.freeze_feedback("turn"),
        lambda f: f.corrupt_feedback("turn"),
        lambda f: f.corrupt_feedback("turn", "zeros", field="current_angle"),
    ],
)
def test_a_condition_without_news(stage: Any, turn: Any, make: Any) -> None:
    """Is never met: no feedback, the first again and again, one that holds no numbers."""
    run = turn(timeout=5, cancel_when="current_angle > 30")
    run.do(make(stage.faults))
    assert outcome(run) == (1.95, "success")


def test_a_condition_on_late_feedback(stage: Any, turn: Any) -> None:
    """Is met late, so the robot has turned on."""
    for by, ended, yaw in ((0.0, 0.8, 0.648), (0.4, 1.2, 1.046)):
        run = turn(timeout=5, cancel_when="current_angle > 30")
        run.do(stage.faults.delay_feedback("turn", by))
        assert outcome(run) == (
            ended,
            "canceled by condition: current_angle > 30 (current_angle = 32.4782)",
        )
        run.until_done()
        assert run.now.yaw == pytest.approx(yaw, abs=0.01)


def test_feedback_of_another_goal_meets_no_condition(stage: Any, turn: Any) -> None:
    """Neither that of a goal nobody sent, nor that of the goal before, which has ended."""
    run = stage.run(
        "mission: m\nworld: empty_arena\ntree:\n  sequence:\n"
        "    - {turn: {angle: 20}, timeout: 5, name: first}\n"
        "    - {turn: {angle: 90}, timeout: 5, name: turn, cancel_when: current_angle > 30}\n"
    )
    run.do(
        stage.faults.forge_feedback("turn"),
        stage.faults.corrupt_feedback("turn", with_angle(99.0, of_number=0), lasting=0.3),
    )
    assert outcome(run)[1].startswith(
        "canceled by condition: current_angle > 30 (current_angle = 3"
    )


def with_angle(angle: float, *, of_number: int) -> Any:
    """Changes the first feedback message of so many."""
    seen: list[Any] = []

    def change(feedback: Any) -> None:
        seen.append(feedback)
        if len(seen) == of_number + 1:
            feedback.current_angle = angle

    return change


@pytest.mark.parametrize(
    ("make", "shown"),
    [
        (lambda f: f.corrupt_feedback("turn", "inf", field="current_angle"), "inf"),
        (lambda f: f.set_feedback("turn", current_angle=30.3), "30.3"),
    ],
)
def test_feedback_that_lies(stage: Any, turn: Any, make: Any, shown: str) -> None:
    """Is believed: the condition is met at once."""
    run = turn(timeout=5, cancel_when="current_angle > 30")
    run.at(0.3, make(stage.faults))
    reason = f"canceled by condition: current_angle > 30 (current_angle = {shown})"
    assert outcome(run) == (0.35, reason)


def test_feedback_that_is_no_number_is_shown_as_such(stage: Any, turn: Any) -> None:
    """Nothing breaks that shows it."""
    run = turn(timeout=5)
    run.do(stage.faults.corrupt_feedback("turn"))
    run.advance(0.5)
    assert math.isnan(run.find("turn").attempt.feedback.current_angle)
    assert "nan" in run.find("turn").feedback_message


def test_a_field_of_a_result_that_is_set(stage: Any) -> None:
    """A variable takes it; how the goal has ended stays."""
    run = stage.run(
        "mission: looks\nworld: empty_arena\ntree:\n  sequence:\n"
        "    - {turn: {angle: 10}, timeout: 9, outputs: {error_code: code}}\n"
        "    - check: $code == 906\n"
    )
    run.do(stage.faults.set_result("turn", error_code=906))
    run.until_done()
    assert run.succeeded


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda f: f.set_feedback("turn", angle=1.0), "unknown field of Turn_Feedback 'angle'"),
        (lambda f: f.set_result("turn", error_code=0.5), "set_result: error_code: "),
        (lambda f: f.set_fields("odom", twist=1.0), "set_fields: twist: "),
    ],
)
def test_a_field_that_cannot_be_set(stage: Any, turn: Any, make: Any, message: str) -> None:
    """Is told as the fault begins."""
    run = turn(timeout=5)
    with pytest.raises(ScenarioError) as caught:
        run.do(make(stage.faults))
    assert message in str(caught.value)
    run.step()
