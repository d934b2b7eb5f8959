"""Variables that follow topics, in named trees, clean-ups, halts and pauses."""

from __future__ import annotations

from typing import Any

from tests.behaviours.test_follow import LOW, head, heard

TREES = """mission: m
follow: {topic: /battery, type: a/msg/B, field: percentage, as: battery}
trees:
  stay:
    follow:
      - {topic: /battery, type: a/msg/B, field: percentage, as: charge}
      - {topic: /on, type: a/msg/B, field: data, as: is_on, initial: true}
    outputs: {charge: number}
    do: {guard: charge > 20 and is_on, do: {wait: 100}}"""


def test_a_named_tree_follows_topics_of_its_own(play: Any) -> None:
    """Entered again, it still does; its outputs give the values of the moment."""
    story = play(
        "  sequence:\n    - force: success\n      do:\n        tree: stay\n"
        "        outputs: {charge: first}\n    - log: $first $battery\n    - tree: stay",
        TREES,
    )
    heard(story, 30.0)
    assert story.tick(2)[:3] == "RRR"
    heard(story, 10.0)
    story.tick()
    assert story.said == ["10 10"]
    assert story.executive.reason.startswith("'guard charge > 20 and is_on' does not hold (charge")


def test_two_uses_of_a_tree_share_a_subscription(play: Any) -> None:
    """Each has a variable of its own."""
    story = play("  parallel: [{tree: stay}, {tree: stay}]\n  fail_when: impossible", TREES)
    heard(story, 30.0)
    assert story.tick() == "RRRRRRR"
    assert len(story.topics["/battery"].listeners) == 3
    story.topics["/on"].publish(data=False)
    story.tick()
    assert story.status == "failure"


def test_a_clean_up_behind_a_halt_reads_the_topic_as_it_is(play: Any) -> None:
    """Other variables are as they were at the halt."""
    story = play(
        "  sequence:\n"
        "    - set: {x: 1}\n"
        "    - force: success\n"
        "      do:\n"
        "        guard: battery > 20\n"
        "        do:\n"
        "          finally: {timeout: 10}\n"
        "          do: {wait: 100}\n"
        "          then: {sequence: [{wait: 0.1}, {log: $battery $x}]}\n"
        "    - set: {x: 2}\n"
        "    - wait: 1\n"
        "    - log: $battery $x",
        head(),
    )
    heard(story, 30.0)
    story.tick()
    heard(story, 10.0)
    story.tick()
    heard(story, 9.0)
    story.tick(4)
    assert story.said == ["9 1"]
    story.tick(20)
    assert story.said == ["9 1", "9 2"]


def test_a_halted_and_repeated_node_reads_what_is_newest(play: Any) -> None:
    """A halt resets no variable that follows a topic."""
    story = play(
        "  repeat: {count: 2}\n  do:\n    parallel:\n      - wait: 0.1\n"
        "      - {sequence: [{log: $battery}, {wait: 9}]}\n    succeed_when: any",
        head(),
    )
    heard(story, 30.0)
    story.tick(3)
    heard(story, 29.0)
    story.tick(3)
    assert story.said == ["30", "29"]


def test_in_a_pause_a_goal_keeps_its_condition(play: Any) -> None:
    """What a topic says counts there, too."""
    story = play("  turn: {angle: 90}\n  cancel_when: $battery < 20", head())
    heard(story, 80.0)
    story.tick()
    story.turn.accept()
    story.executive.pause("test", keep_goals=True)
    story.tick()
    heard(story, 10.0)
    story.tick()
    assert len(story.turn.cancels) == 1


def test_a_run_repeats_byte_for_byte(play: Any) -> None:
    """The same messages at the same times give the same trace."""

    def digest() -> str:
        story = play(LOW, head())
        for value in (30.0, 25.0, 21.0, 19.0):
            heard(story, value)
            story.tick(3)
        assert story.status == "failure"
        return str(story.trace.sha256)

    assert digest() == digest()
