"""What control flow says and draws, beyond the statuses in test_statuses.py."""

from __future__ import annotations

from typing import Any

from tests.support.play import message


def test_choose_draws_from_the_missions_seed(play: Any) -> None:
    """In proportion to the weights, and the same in every run of one seed."""
    tree = "  repeat: {count: 400}\n  do:\n    choose: [{log: a}, {log: b}]\n    weights: [3, 1]"
    said = []
    for seed in (1, 1, 2):
        story = play(tree, f"mission: t\nseed: {seed}")
        story.tick(400)
        said.append("".join(story.said))
    assert said[0] == said[1] != said[2]
    assert 0.7 < said[0].count("a") / 400 < 0.8


def test_for_each_hands_over_each_element_and_takes_the_variable_away(play: Any) -> None:
    """Lists of lists, too; behind the loop the name means nothing."""
    story = play("  for_each: {p: [[1, 2], [3]]}\n  do: {log: '${len(p)} of $p'}")
    story.tick(2)
    assert story.status == "success"
    assert story.said == ["2 of 1, 2", "1 of 3"]
    assert story.scope.values == {}


def test_set_works_one_after_another(play: Any) -> None:
    """A value may read the one before it, and the message says what was set."""
    story = play("  sequence: [{set: {a: 2, b: a * 3, c: \"'x'\", d: [1, 2]}}, {log: $b $c}]")
    story.tick()
    assert story.said == ["6 x"]
    assert story.root.children[0].feedback_message == "a = 2, b = 6, c = x, d = a list of 2"


def test_a_condition_says_what_it_read(play: Any) -> None:
    """In the reason of the failure."""
    story = play("  check: speed > 1 and legs == 2", "mission: t\ninputs: {speed: 2, legs: 3}")
    story.tick()
    assert story.executive.reason == (
        "'check speed > 1 and legs == 2' does not hold (speed = 2, legs = 3)"
    )


def test_a_condition_is_asked_anew_when_what_it_reads_has_changed(play: Any) -> None:
    """And only then, for what is plain: a text of its own is the same one."""
    story = play("  guard: x >= 1\n  do: {wait: 60}", "mission: m\ninputs: {x: 1}")
    messages = []
    for value in (1, 2.5, 2.5, 0):
        story.scope.values["x"] = value
        story.tick()
        messages.append(story.root.feedback_message)
    assert messages == ["holds (x = 1)", *["holds (x = 2.5)"] * 2, "does not hold (x = 0)"]
    assert messages[1] is messages[2]


def test_a_condition_on_a_list_is_always_asked(play: Any) -> None:
    """A list may change in its place."""
    story = play("  guard: len(x) < 2\n  do: {wait: 60}", "mission: m\ninputs: {x: [1]}")
    story.tick()
    story.scope.values["x"].append(2)
    story.tick()
    assert story.root.feedback_message == "does not hold (x = a list of 2)"


def test_a_condition_that_draws_is_always_asked(play: Any) -> None:
    """At each tick it is another number."""
    story = play("  guard: uniform(0, 1) < 0.8\n  do: {wait: 60}")
    assert story.tick() == "RR"
    story.tick(30)
    assert story.status == "failure"


def test_a_timeout_says_what_it_was(play: Any) -> None:
    """And the mission's reason names the node, rather than the child that was halted."""
    story = play("  timeout: 0.1\n  do: {wait: 5}\n  name: hurry")
    assert story.tick() == "RR"
    assert story.root.feedback_message == "0.1 s left"
    story.tick(2)
    assert story.executive.reason == "'hurry' not done within 0.1 s"


def test_a_condition_that_is_neither_true_nor_false_fails_the_mission(play: Any) -> None:
    """Its type shows only at run time, where an element of a mixed list is asked."""
    story = play("  for_each: {one: [true, 3]}\n  do: {check: $one}")
    story.tick(2)
    assert story.status == "failure"
    assert "'$one' gave 3, not a boolean" in story.executive.reason


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
        story = play(f"  sequence:\n    - set: {{n: 0}}\n    - {loop}", head)
        messages = []
        while story.status == "running":
            story.tick()
            messages.append(story.root.children[1].feedback_message)
        assert len(messages) == rounds
        first = f"1 of at most {most} rounds done, condition does not hold (n = 1)"
        assert messages[0] == first
        assert (story.status, story.executive.reason) == (status, reason)


def test_a_loop_without_progress_takes_a_tick_a_round(play: Any) -> None:
    """A thousand rounds that take no time are a thousand ticks, and an interrupt ends them."""
    story = play("  repeat: {while: true}\n  do: {log: again}")
    story.tick(1000)
    assert story.said == ["again"] * 1000
    story.executive.interrupt("enough")
    story.tick()
    assert story.status == "interrupted"


DRIVE = "{turn: {angle: 90}, timeout: 99, on_cancel: success, cancel_when: %s}"


def test_a_goal_is_cancelled_when_a_variable_changes(play: Any) -> None:
    """In the tick in which its leaf sees that, without any feedback."""
    steps = "{sequence: [{wait: 0.3}, {set: {n: 4}}]}"
    drive = DRIVE % "$n > 3"
    story = play(f"  sequence:\n    - set: {{n: 0}}\n    - parallel: [{steps}, {drive}]")
    story.tick()
    story.turn.accept()
    story.tick(5)
    assert not story.turn.cancels
    story.tick()
    assert story.turn.cancels
    story.turn.goal.on_result(5, None)
    story.tick()
    assert story.status == "success"
    leaf = story.root.children[1].children[1]
    assert leaf.feedback_message == "canceled by condition: $n > 3 (n = 4)"


def test_a_condition_that_holds_from_the_start_cancels_an_accepted_goal(play: Any) -> None:
    """What it reads need not change."""
    story = play(f"  sequence:\n    - set: {{n: 5}}\n    - {DRIVE % '$n > 3'}")
    story.tick(3)
    assert not story.turn.cancels
    story.turn.accept()
    story.tick()
    assert story.turn.cancels


def test_a_condition_on_both_is_asked_again_with_the_newest_feedback(play: Any) -> None:
    """And not before there is one."""
    steps = "{sequence: [{wait: 0.2}, {set: {far: 9}}, {wait: 0.2}, {set: {far: 1}}]}"
    drive = DRIVE % "current_angle > $far"
    story = play(f"  sequence:\n    - set: {{far: 5}}\n    - parallel: [{steps}, {drive}]")
    story.tick()
    story.turn.accept()
    story.tick(5)
    story.turn.goal.on_feedback(message(current_angle=2.0))
    story.tick(2)
    assert not story.turn.cancels
    story.tick(3)
    assert story.turn.cancels
