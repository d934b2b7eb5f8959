"""Pauses, steps and breakpoints, tick by tick."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.goals.goal import GoalTrigger
from tests.support.play import message


def state(run: Any) -> MissionState:
    """What viewers know of the mission."""
    result: MissionState = run.executive.mission_state
    return result


LEAVES = (
    "  sequence:\n    - check: true\n      name: a\n    - check: true\n      name: b\n"
    "    - check: true\n      name: c\n"
)


def test_a_tick_goes_on_where_it_stopped(play: Any) -> None:
    """What came before the breakpoint is not run again: still the first tick."""
    run = play(LEAVES)
    run.executive.breakpoints.add("b")
    run.tick()
    assert run.executive.reason == "breakpoint at 'b'"
    assert run.statuses[1:] == "SII"
    run.tick()
    assert run.statuses[1:] == "SII"
    run.executive.resume()
    run.tick()
    assert (state(run).status, run.executive.ticks) == ("success", 1)


def test_a_step_stops_at_the_next_breakpoint(play: Any) -> None:
    """Within the same tick of the tree."""
    run = play(LEAVES)
    run.executive.breakpoints.add("b")
    run.executive.breakpoints.add("c")
    run.tick()
    run.executive.step()
    run.tick()
    assert run.executive.reason == "breakpoint at 'c'"
    run.executive.step()
    run.tick()
    assert state(run).status == "success"


@pytest.mark.parametrize(
    "tree",
    [
        "  fallback:\n    - {do}\n    - check: true\n",
        "  parallel:\n    - {do}\n    - check: true\n",
        "  choose:\n    - {do}\n",
        "  when: true\n  do:\n    {do}\n",
        "  guard: true\n  do:\n    {do}\n",
        "  timeout: 5\n  do:\n    {do}\n",
        "  repeat: {{count: 2}}\n  do:\n    {do}\n",
        "  retry: {{attempts: 2}}\n  do:\n    {do}\n",
        "  for_each: {{x: [1, 2]}}\n  do:\n    {do}\n",
        "  force: success\n  do:\n    {do}\n",
        "  invert:\n    invert:\n      {do}\n",
    ],
)
def test_every_parent_passes_a_breakpoint_on(play: Any, tree: str) -> None:
    """And comes to the end that it has without one."""
    run = play(tree.format(do="log: x"))
    run.executive.breakpoints.add("log")
    for _ in range(10):
        run.tick()
        run.executive.resume()
    assert state(run).status == "success"
    stops = [line for line in run.trace.newest if '"event": "paused"' in line]
    assert len(stops) == (2 if "repeat" in tree or "for_each" in tree else 1)


def test_halted_at_a_breakpoint(play: Any) -> None:
    """A mission that is stopped there ends as elsewhere."""
    run = play(LEAVES)
    run.executive.breakpoints.add("b")
    run.tick()
    run.executive.interrupt("enough")
    run.tick()
    assert (state(run).status, run.executive.reason) == ("interrupted", "enough")


def test_at_a_breakpoint_goals_beside_it_are_cancelled(play: Any) -> None:
    """They start anew after the pause."""
    run = play("  parallel:\n    - turn: {angle: 9}\n    - sequence: [{wait: 1}, {log: x}]\n")
    run.tick()
    run.turn.accept()
    run.executive.breakpoints.add("log")
    run.tick(25)
    assert state(run).status == "paused"
    assert len(run.turn.cancels) == 1
    run.turn.cancel()
    run.executive.resume()
    run.tick(2)
    assert len(run.turn.goals) == 2


def test_a_breakpoint_by_name_means_all_of_that_name(play: Any) -> None:
    """Removed, they are gone; one set twice by different names stays with the other."""
    run = play("  sequence: [{log: x}, {log: y}, {wait: 1}]\n")
    points = run.executive.breakpoints
    assert points.add("log") == 2
    assert points.add("0.1") == 1
    points.remove("log")
    with pytest.raises(BtMissionError, match="no breakpoint on 'log'"):
        points.remove("log")
    run.tick()
    assert run.executive.reason == "breakpoint at 'log'"
    assert run.statuses[1:] == "SII"


# ---- goals that a step, or a pause that keeps them, leaves under way -----------------------------

LIMITS = "  turn: {angle: 9}\n  cancel_when: way > 0.3\n  on_cancel: success\n  timeout: 5\n"


def stepped(play: Any, tree: str, node: str = "turn") -> Any:
    """A mission that stands at a breakpoint, and has made one step beyond it; its goal runs."""
    run = play(tree)
    run.executive.breakpoints.add(node)
    run.tick()
    run.executive.step()
    run.tick()
    run.executive.breakpoints.remove(node)
    run.turn.accept()
    run.tick()
    assert state(run).explanation == f"breakpoint at '{node}'; still running: '{node}'"
    return run


def test_a_condition_is_watched_during_a_pause(play: Any) -> None:
    """The goal is cancelled at once; its node is told by the next tick of the tree."""
    run = stepped(play, LIMITS)
    run.turn.feed(message(way=0.2))
    run.tick()
    assert run.turn.cancels == []
    run.turn.feed(message(way=0.31))
    run.tick()
    assert len(run.turn.cancels) == 1
    assert state(run).explanation == "breakpoint at 'turn'; still running: 'turn' (canceling)"
    run.turn.cancel()
    run.tick(100)
    assert (state(run).status, state(run).explanation) == (
        "paused",
        "breakpoint at 'turn'",
    )
    assert run.executive.root.feedback_message.startswith("canceled by condition: way > 0.3")
    run.executive.resume()
    run.tick()
    assert (state(run).status, len(run.turn.goals)) == ("success", 1)


@pytest.mark.parametrize(
    ("tree", "feeds", "ticks", "why"),
    [
        (LIMITS, "", 100, "canceled by timeout: not done within 5 s"),
        (
            "  turn: {angle: 9}\n  feedback_timeout: 1\n",
            "",
            20,
            "feedback silent for too long: no feedback for 1 s",
        ),
        (
            "  timeout: 2\n  do:\n    sequence:\n      - turn: {angle: 9}\n        timeout: 60\n",
            "feeds",
            38,
            "canceled by halt: 'test': not done within 2 s",
        ),
    ],
)
def test_a_limit_is_kept_during_a_pause(
    play: Any, tree: str, feeds: str, ticks: int, why: str
) -> None:
    """To the tick: a goal's own limits, and those of nodes around it."""
    run = stepped(play, tree)
    for _ in range(ticks - 1):
        if feeds:
            run.turn.feed(message(way=0.0))
        run.tick()
    assert run.turn.cancels == []
    run.tick()
    assert len(run.turn.cancels) == 1
    run.turn.cancel()
    run.tick()
    assert (state(run).status, run.ledger.open_goals) == ("paused", ())
    run.executive.resume()
    run.tick()
    assert (state(run).status, len(run.turn.goals)) == ("failure", 1)
    assert run.executive.reason == f"'turn' {why}"


def test_an_unanswered_goal_is_given_up_during_a_pause(play: Any) -> None:
    """After its acceptance timeout, of 2 s; if it is accepted after all, it is cancelled."""
    run = play("  turn: {angle: 9}\n")
    run.tick()
    run.executive.pause("by hand", keep_goals=True)
    run.tick(39)
    assert state(run).explanation == "by hand; still running: 'turn'"
    run.tick()
    assert state(run).explanation == "by hand; still running: 'turn' (canceling)"
    run.turn.accept()
    run.turn.cancel()
    run.tick()
    assert state(run).explanation == "by hand"
    run.executive.resume()
    run.tick()
    assert "no answer to the goal" in run.executive.reason


def test_a_guard_is_asked_during_a_pause(play: Any) -> None:
    """Its goal is halted as soon as it holds no longer."""
    tree = "  guard: go\n  do:\n    turn: {angle: 9}\n"
    run = play(tree, head="mission: test\ninputs: {go: true}")
    run.tick()
    run.turn.accept()
    run.executive.pause("by hand", keep_goals=True)
    run.tick(100)
    assert run.turn.cancels == []
    run.scope.values["go"] = False
    run.tick()
    assert len(run.turn.cancels) == 1
    assert run.executive.root.children[0].feedback_message.startswith("canceled by halt: 'test'")


def test_a_condition_that_cannot_be_evaluated_ends_a_paused_mission(play: Any) -> None:
    """As it does one that is not paused; the goal is cancelled."""
    run = stepped(play, "  turn: {angle: 9}\n  cancel_when: 1 / way > 2\n")
    run.turn.feed(message(way=0.0))
    run.tick()
    assert len(run.turn.cancels) == 1
    run.turn.cancel()
    run.tick()
    assert state(run).status == "failure"
    assert "zero" in run.executive.reason


def test_no_goal_is_sent_during_a_pause(play: Any) -> None:
    """Not even when the server that a leaf waits for comes."""
    run = play("  turn: {angle: 9}\n  server_timeout: 60\n")
    run.turn.ready = False
    run.tick()
    run.executive.pause("by hand", keep_goals=True)
    run.turn.ready = True
    run.tick(100)
    assert run.turn.goals == []
    run.executive.resume()
    run.tick()
    assert len(run.turn.goals) == 1


def test_goals_side_by_side_keep_limits_of_their_own(play: Any) -> None:
    """The first to hit one is cancelled; the other runs on, and its success counts."""
    run = play(
        "  parallel:\n"
        "    - turn: {angle: 9}\n      name: short\n      timeout: 2\n"
        "    - turn: {angle: 9}\n      name: long\n      timeout: 4\n"
    )
    run.tick()
    short, long = run.turn.goals
    for goal in (short, long):
        goal.on(GoalTrigger.ACCEPTED)
    run.tick()
    run.executive.pause("by hand", keep_goals=True)
    run.tick(40)
    assert run.turn.cancels == [short]
    short.on_result(5, None)
    run.tick()
    assert state(run).explanation == "by hand; still running: 'long'"
    long.on_result(4, None)
    run.tick(100)
    assert run.turn.cancels == [short]
    run.executive.resume()
    run.tick()
    assert run.statuses == "FFS"


def test_a_retry_begins_after_the_pause(play: Any) -> None:
    """A goal that fails during the pause is not sent again before it ends."""
    run = stepped(play, "  retry: {attempts: 2}\n  do:\n    turn: {angle: 9}\n")
    run.turn.abort()
    run.tick(100)
    assert len(run.turn.goals) == 1
    run.executive.resume()
    run.tick(2)
    assert len(run.turn.goals) == 2


def test_a_second_pause_cancels_what_a_step_has_started(play: Any) -> None:
    """Unless it has ended: then its outcome counts."""
    run = stepped(play, "  turn: {angle: 9}\n")
    run.executive.pause("by hand")
    run.tick()
    assert len(run.turn.cancels) == 1
    run.turn.cancel()
    run.executive.step()
    run.tick()
    assert len(run.turn.goals) == 2
    run.turn.accept()
    run.turn.succeed()
    run.executive.pause("by hand")
    run.executive.resume()
    run.tick()
    assert (state(run).status, len(run.turn.goals)) == ("success", 2)


def test_a_stop_during_a_pause_cancels_what_is_under_way(play: Any) -> None:
    """And waits for the confirmation, as ever."""
    run = stepped(play, LIMITS)
    run.executive.interrupt("enough")
    run.tick()
    assert (state(run).status, len(run.turn.cancels)) == ("ending", 1)
    run.turn.cancel()
    run.tick()
    assert (state(run).status, run.executive.reason) == ("interrupted", "enough")
