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


def test_for_each_hands_over_each_element_and_takes_the_variable_away(play: Any) -> None:
    """Lists of lists, too; behind the loop the name means nothing."""
    run = play("  for_each: {p: [[1, 2], [3]]}\n  do: {log: '${len(p)} of $p'}")
    run.tick(2)
    assert run.status == "success"
    assert run.logged == ["2 of 1, 2", "1 of 3"]
    assert run.scope.values == {}


def test_set_works_one_after_another(play: Any) -> None:
    """A value may read the one before it, and the message says what was set."""
    run = play("  sequence: [{set: {a: 2, b: a * 3, c: \"'x'\", d: [1, 2]}}, {log: $b $c}]")
    run.tick()
    assert run.logged == ["6 x"]
    assert run.root.children[0].feedback_message == "a = 2, b = 6, c = x, d = a list of 2"


def test_a_condition_says_what_it_read(play: Any) -> None:
    """In the reason of the failure."""
    run = play("  check: speed > 1 and legs == 2", "mission: t\ninputs: {speed: 2, legs: 3}")
    run.tick()
    assert run.executive.reason == (
        "'check speed > 1 and legs == 2' does not hold (speed = 2, legs = 3)"
    )


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


def test_a_condition_that_draws_is_always_asked(play: Any) -> None:
    """At each tick it is another number."""
    run = play("  guard: uniform(0, 1) < 0.8\n  do: {wait: 60}")
    assert run.tick() == "RR"
    run.tick(30)
    assert run.status == "failure"


def test_a_timeout_says_what_it_was(play: Any) -> None:
    """And the mission's reason names the node, rather than the child that was halted."""
    run = play("  timeout: 0.1\n  do: {wait: 5}\n  name: hurry")
    assert run.tick() == "RR"
    assert run.root.feedback_message == "0.1 s left"
    run.tick(2)
    assert run.executive.reason == "'hurry' not done within 0.1 s"


def test_a_condition_that_is_neither_true_nor_false_fails_the_mission(play: Any) -> None:
    """Its type shows only at run time, where an element of a mixed list is asked."""
    run = play("  for_each: {one: [true, 3]}\n  do: {check: $one}")
    run.tick(2)
    assert run.status == "failure"
    assert "'$one' gave 3, not a boolean" in run.executive.reason


def test_a_loop_says_why_it_goes_on_or_ends(play: Any) -> None:
    """With the rounds done, and what its condition read."""
    loop = "repeat: {until: n > 2, count: $most}\n      do: {set: {n: n + 1}}"
    no = "condition does not hold"
    for most, rounds, status, reason in (
        (5, 3, "success", ""),
        (
            2,
            2,
            "failure",
            f"'repeat' not ended by its condition: 2 of at most 2 rounds done, {no} (n = 2)",
        ),
    ):
        head = f"mission: m\ninputs: {{most: {most}}}"
        run = play(f"  sequence:\n    - set: {{n: 0}}\n    - {loop}", head)
        messages = []
        while run.status == "running":
            run.tick()
            messages.append(run.root.children[1].feedback_message)
        assert len(messages) == rounds
        first = f"1 of at most {most} rounds done, condition does not hold (n = 1)"
        assert messages[0] == first
        assert (run.status, run.executive.reason) == (status, reason)


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
