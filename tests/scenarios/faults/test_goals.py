"""Faults between action servers and their clients, and what a mission answers."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.executive.goals.goal import NO_CALLBACK
from bt_mission.ros.virtual_time import Delivery, Side
from bt_mission.scenarios.faults.errors import ScenarioError
from tests.support.faulty_runs import outcome
from tests.support.thorough import sample

TURN = "mission: m\nworld: empty_arena\ntree: {turn: {angle: 90}, timeout: 5}\n"


def lives(run: Any) -> list[str]:
    """What became of each goal, without its name."""
    return [str(goal).partition("(")[2] for goal in run.goals]


def test_without_a_fault(turn: Any) -> None:
    """What the faults change."""
    run = turn(timeout=5)
    assert outcome(run) == (1.95, "success")
    assert lives(run) == ["sent at 0.05 s, ended at 1.95 s): succeeded"]


def test_goals_are_rejected(stage: Any, turn: Any) -> None:
    """So many; the server does not hear of them, the robot stands."""
    run = turn(timeout=5)
    run.do(stage.faults.reject_goals("turn", 1))
    assert outcome(run) == (0.1, "rejected: /turn: its server gave no reason")
    assert [fault.ended_ns for fault in run.faults] == [1_050_000_000]
    run.until_done()
    assert (run.succeeded, run.now.yaw) == (True, pytest.approx(0, abs=1e-6))


def test_a_retry_after_two_rejections_succeeds(stage: Any) -> None:
    """The third goal is accepted."""
    run = stage.run(
        "mission: m\nworld: empty_arena\n"
        "tree: {retry: {attempts: 3, pause: 0.2}, do: {turn: {angle: 30}, timeout: 5}}\n"
    )
    run.do(stage.faults.reject_goals("turn", 2))
    run.until_done()
    assert run.succeeded
    assert [goal.status for goal in run.goals] == [None, None, "succeeded"]


def test_goals_are_ignored(stage: Any, turn: Any) -> None:
    """The server never hears of it, so nothing can tell that it has ended."""
    run = turn(timeout=5)
    run.do(stage.faults.ignore_goals("turn"))
    assert outcome(run) == (2.05, "no answer to the goal: /turn did not answer the goal within 2 s")
    run.until_done()
    assert (run.t, run.status) == (5.05, "failure")
    assert run.reason.startswith("orphaned goals: /turn goal ")
    assert run.check("always abs(turn_rate) < 1e-3")
    (left,) = run.close()
    assert left.endswith("of 'turn' (lost)")


def test_an_answer_that_is_lost_leaves_no_robot_turning(stage: Any, turn: Any) -> None:
    """The goal is cancelled by its id all the same; that the server cancels it says that it is."""
    run = turn(timeout=5, acceptance_timeout=1)
    run.do(stage.faults.drop_answers("turn"))
    assert outcome(run) == (1.05, "no answer to the goal: /turn did not answer the goal within 1 s")
    assert run.now.turn_rate == pytest.approx(1.0, abs=0.01)
    run.until_done()
    assert (run.succeeded, run.t) == (True, 2.05)
    assert lives(run) == ["sent at 0.05 s, released at 1.05 s, ended at 1.10 s): canceled"]
    assert run.check("whenever time >= 1.5: abs(turn_rate) < 0.01")


def test_a_late_answer(stage: Any, turn: Any) -> None:
    """In time it is no matter; too late it changes nothing any more."""
    run = turn(timeout=5)
    run.do(stage.faults.delay_answers("turn", 1.0, 1))
    assert outcome(run) == (1.95, "success")
    run = turn(timeout=5, acceptance_timeout=0.5)
    run.do(stage.faults.delay_answers("turn", 1.0))
    assert outcome(run)[0] == 0.55
    run.until_done()
    assert lives(run) == ["sent at 0.05 s, released at 0.55 s, ended at 0.60 s): canceled"]


def test_an_answer_after_the_halt(stage: Any) -> None:
    """The goal that is accepted then is cancelled; it had been, before."""
    run = stage.run(
        "mission: m\nworld: empty_arena\n"
        "tree: {fallback: [{timeout: 0.5, do: {turn: {angle: 90}, timeout: 5}}, {wait: 1}]}\n"
    )
    run.do(stage.faults.answer_after_halt("turn", after=0.3))
    answers: list[float] = []
    run.do(heard_at(answers))
    run.until_done()
    assert answers == [0.85]
    assert lives(run) == ["sent at 0.05 s, released at 0.55 s, ended at 0.60 s): canceled"]
    assert run.check("whenever time >= 1.0: abs(turn_rate) < 0.01")


def test_an_answer_is_held_for_so_long_at_most(stage: Any, turn: Any) -> None:
    """And to the end of the fault."""
    for at_most, lasting, received in ((0.7, None, 0.75), (None, 0.4, 0.4)):
        run = turn(timeout=5)
        run.do(stage.faults.answer_after_halt("turn", at_most=at_most, lasting=lasting))
        answers: list[float] = []
        run.do(heard_at(answers))
        assert outcome(run) == (1.95, "success")
        assert answers == [received]


@pytest.mark.parametrize("after", sample([0.0, 0.1, 5.0], 3))
@pytest.mark.parametrize("part", ["goal", "cancel", "result"])
def test_an_answer_that_comes_twice(stage: Any, turn: Any, part: str, after: float) -> None:
    """At once, later, and when the goal is long over: the first counts."""
    run = turn(timeout=1)
    run.do(stage.faults.repeat_answers("turn", part, times=3, after=after))
    assert outcome(run) == (1.15, "canceled by timeout: not done within 1 s")
    run.until_done()
    assert lives(run) == ["sent at 0.05 s, ended at 1.15 s): canceled"]


def test_a_late_result(stage: Any, turn: Any) -> None:
    """The leaf waits for it, also after its timeout, and then says that it is late."""
    run = turn(timeout=5)
    run.do(stage.faults.delay_results("turn", 1.0))
    assert outcome(run) == (2.95, "success")
    run = turn(timeout=2)
    run.do(stage.faults.delay_results("turn", 1.0))
    assert outcome(run) == (
        2.95,
        "succeeded late: /turn succeeded after its timeout of 2 s, 2.85 s after its acceptance",
    )


def test_a_result_that_is_lost_is_asked_for_again(stage: Any, turn: Any) -> None:
    """Once the limit is over: the cancel finds that the goal has ended."""
    run = turn(timeout=3)
    run.do(stage.faults.drop_results("turn", 1))
    assert outcome(run) == (
        3.15,
        "succeeded late: /turn succeeded after its timeout of 3 s, 3.05 s after its acceptance",
    )


def test_a_result_that_is_lost_for_ever(stage: Any, turn: Any) -> None:
    """The goal is named; the robot stands all the same."""
    run = turn(timeout=2, cancel_timeout=1)
    run.do(stage.faults.drop_results("turn"))
    assert outcome(run) == (
        3.1,
        "unconfirmed: not done within 2 s, but /turn sent no result of the ended goal in 1 s",
    )
    run.until_done()
    assert "orphaned goals: /turn goal" in run.reason
    assert len(run.close()) == 1
    assert run.now.turn_rate == pytest.approx(0, abs=1e-3)


def test_cancels_are_refused(stage: Any, turn: Any) -> None:
    """The leaf says so at once; it is asked again after a second, until the server takes it."""
    run = turn(timeout=0.5)
    run.do(stage.faults.refuse_cancels("turn", 1))
    assert outcome(run) == (
        0.65,
        f"cancel refused: not done within 0.5 s, but /turn refused to cancel{NO_CALLBACK}",
    )
    run.until_done()
    assert lives(run) == ["sent at 0.05 s, released at 0.65 s, ended at 0.70 s): canceled"]


def test_all_cancels_are_refused(stage: Any, turn: Any) -> None:
    """The goal runs to its end."""
    run = turn(timeout=0.5)
    run.do(stage.faults.refuse_cancels("turn"))
    run.until_done()
    assert lives(run) == ["sent at 0.05 s, released at 0.65 s, ended at 1.95 s): succeeded"]


def test_cancels_are_lost(stage: Any, turn: Any) -> None:
    """Nothing confirms them within the limit; the second is heard."""
    run = turn(timeout=0.5, cancel_timeout=0.5)
    run.do(stage.faults.ignore_cancels("turn", 1))
    assert outcome(run) == (
        1.1,
        "unconfirmed: not done within 0.5 s, but /turn did not confirm the cancel in 0.5 s",
    )
    run.until_done()
    assert lives(run) == ["sent at 0.05 s, released at 1.10 s, ended at 1.15 s): canceled"]


def test_a_slow_server(stage: Any, turn: Any) -> None:
    """Half a second for each request, answer and feedback, so its turn is over later."""
    run = turn(timeout=5)
    run.do(stage.faults.slow_server("turn", 0.5))
    feedback: list[float] = []
    run.do(heard_at(feedback, "feedback"))
    assert run.until(lambda s: abs(s.turn_rate) > 0.01).t == 0.6
    assert outcome(run) == (2.9, "success")
    assert feedback[0] == 1.05


def test_a_server_too_slow_for_its_limits(stage: Any, turn: Any) -> None:
    """The cancel comes after the goal, and ends it."""
    run = turn(timeout=5, acceptance_timeout=0.5)
    run.do(stage.faults.slow_server("turn", 0.4))
    assert outcome(run)[1].startswith("no answer to the goal")
    run.until_done()
    assert run.succeeded
    assert [goal.status for goal in run.goals] == ["canceled"]


def test_a_server_that_the_test_plays(stage: Any, scripted_server: Any) -> None:
    """The same faults."""
    server = scripted_server("turn")
    run = stage.run(TURN)
    run.do(stage.faults.delay_answers("turn", 0.4), stage.faults.reject_goals("/turn", 1))
    assert outcome(run)[1].startswith("rejected: ")
    run = stage.run(TURN)
    run.do(stage.faults.delay_answers("turn", 0.4))
    run.until(lambda s: server.goals)
    server.goal.succeed()
    assert outcome(run) == (0.45, "success")


def test_actions_that_are_not_there(stage: Any) -> None:
    """Those that are stand in the error."""
    run = stage.run(TURN)
    with pytest.raises(ScenarioError, match=r"unknown action '/tern'"):
        run.do(stage.faults.reject_goals("tern"))
    run.step()


def heard_at(times: list[float], part: str = "send_goal") -> Any:
    """An action that notes when a part of the turn comes to its client."""

    def begin(run: Any) -> None:
        def note(passing: Any) -> list[Any]:
            times.append(run.history.seconds(passing.time_ns))
            return [Delivery(passing.message)]

        side = Side.MESSAGE if part == "feedback" else Side.RESPONSE
        run.stage.clock.taps.add(f"/turn/_action/{part}", side, note)

    return begin
