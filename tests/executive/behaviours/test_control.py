"""What control flow says and draws, beyond the statuses in test_statuses.py."""

from __future__ import annotations

from typing import Any

from tests.support.play import message


def test_choose_draws_from_the_missions_seed(play: Any) -> None:
    """In proportion to the weights, and the same in every run of one seed."""
    tree = "  repeat: {count: 400}\n  do:\n    choose: [{log: a}, {log: b}]\n    weights: [3, 1]"
    lines = []
    for seed in (1, 1, 2):
        run = play(tree, f"mission: t\nseed: {seed}")
        run.tick(400)
        lines.append("".join(run.logged))
    assert lines[0] == lines[1] != lines[2]
    assert 0.7 < lines[0].count("a") / 400 < 0.8


def test_a_condition_is_asked_anew_when_what_it_reads_has_changed(play: Any) -> None:
    """And only then, for what is plain: a text of its own is the same one."""
    run = play("  guard: x >= 1\n  do: {wait: 60}", "mission: m\ninputs: {x: 1}")
    messages = []
    for value in (1, 2.5, 2.5, 0):
        run.scope.values["x"] = value
        run.tick()
        messages.append(run.root.feedback_message)
    assert messages == ["holds (x = 1)", *["holds (x = 2.5)"] * 2, "does not hold (x = 0)"]
    assert messages[1] is messages[2]


def test_a_condition_on_a_list_is_always_asked(play: Any) -> None:
    """A list may change in its place."""
    run = play("  guard: len(x) < 2\n  do: {wait: 60}", "mission: m\ninputs: {x: [1]}")
    run.tick()
    run.scope.values["x"].append(2)
    run.tick()
    assert run.root.feedback_message == "does not hold (x = a list of 2)"


def test_a_loop_without_progress_takes_a_tick_a_round(play: Any) -> None:
    """A thousand rounds that take no time are a thousand ticks, and an interrupt ends them."""
    run = play("  repeat: {while: true}\n  do: {log: again}")
    run.tick(1000)
    assert run.logged == ["again"] * 1000
    run.executive.interrupt("enough")
    run.tick()
    assert run.status == "interrupted"


DRIVE = "{turn: {angle: 90}, timeout: 99, on_cancel: success, cancel_when: %s}"


def test_a_goal_is_cancelled_when_a_variable_changes(play: Any) -> None:
    """In the tick in which its leaf sees that, without any feedback."""
    steps = "{sequence: [{wait: 0.3}, {set: {n: 4}}]}"
    drive = DRIVE % "$n > 3"
    run = play(f"  sequence:\n    - set: {{n: 0}}\n    - parallel: [{steps}, {drive}]")
    run.tick()
    run.turn.accept()
    run.tick(5)
    assert not run.turn.cancels
    run.tick()
    assert run.turn.cancels
    run.turn.goal.on_result(5, None)
    run.tick()
    assert run.status == "success"
    leaf = run.root.children[1].children[1]
    assert leaf.feedback_message == "canceled by condition: $n > 3 (n = 4)"


def test_a_condition_that_holds_from_the_start_cancels_an_accepted_goal(play: Any) -> None:
    """What it reads need not change."""
    run = play(f"  sequence:\n    - set: {{n: 5}}\n    - {DRIVE % '$n > 3'}")
    run.tick(3)
    assert not run.turn.cancels
    run.turn.accept()
    run.tick()
    assert run.turn.cancels


def test_a_condition_on_both_is_asked_again_with_the_newest_feedback(play: Any) -> None:
    """And not before there is one."""
    steps = "{sequence: [{wait: 0.2}, {set: {far: 9}}, {wait: 0.2}, {set: {far: 1}}]}"
    drive = DRIVE % "current_angle > $far"
    run = play(f"  sequence:\n    - set: {{far: 5}}\n    - parallel: [{steps}, {drive}]")
    run.tick()
    run.turn.accept()
    run.tick(5)
    run.turn.goal.on_feedback(message(current_angle=2.0))
    run.tick(2)
    assert not run.turn.cancels
    run.tick(3)
    assert run.turn.cancels
