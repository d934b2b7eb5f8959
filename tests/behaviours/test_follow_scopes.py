"""Variables that follow topics, in named trees, clean-ups, halts and pauses."""

from __future__ import annotations

from typing import Any

from tests.behaviours.test_follow import LOW, head, receive

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
    run = play(
        "  sequence:\n    - force: success\n      do:\n        tree: stay\n"
        "        outputs: {charge: first}\n    - log: $first $battery\n    - tree: stay",
        TREES,
    )
    receive(run, 30.0)
    assert run.tick(2)[:3] == "RRR"
    receive(run, 10.0)
    run.tick()
    assert run.logged == ["10 10"]
    assert run.executive.reason.startswith("'guard charge > 20 and is_on' does not hold (charge")


def test_two_uses_of_a_tree_share_a_subscription(play: Any) -> None:
    """Each has a variable of its own."""
    run = play("  parallel: [{tree: stay}, {tree: stay}]\n  fail_when: impossible", TREES)
    receive(run, 30.0)
    assert run.tick() == "RRRRRRR"
    assert len(run.topics["/battery"].listeners) == 3
    run.topics["/on"].publish(data=False)
    run.tick()
    assert run.status == "failure"


def test_a_clean_up_behind_a_halt_reads_the_topic_as_it_is(play: Any) -> None:
    """Other variables are as they were at the halt."""
    run = play(
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
    receive(run, 30.0)
    run.tick()
    receive(run, 10.0)
    run.tick()
    receive(run, 9.0)
    run.tick(4)
    assert run.logged == ["9 1"]
    run.tick(20)
    assert run.logged == ["9 1", "9 2"]


def test_a_halted_and_repeated_node_reads_what_is_newest(play: Any) -> None:
    """A halt resets no variable that follows a topic."""
    run = play(
        "  repeat: {count: 2}\n  do:\n    parallel:\n      - wait: 0.1\n"
        "      - {sequence: [{log: $battery}, {wait: 9}]}\n    succeed_when: any",
        head(),
    )
    receive(run, 30.0)
    run.tick(3)
    receive(run, 29.0)
    run.tick(3)
    assert run.logged == ["30", "29"]


def test_in_a_pause_a_goal_keeps_its_condition(play: Any) -> None:
    """What a topic says counts there, too."""
    run = play("  turn: {angle: 90}\n  cancel_when: $battery < 20", head())
    receive(run, 80.0)
    run.tick()
    run.turn.accept()
    run.executive.pause("test", keep_goals=True)
    run.tick()
    receive(run, 10.0)
    run.tick()
    assert len(run.turn.cancels) == 1


def test_a_run_repeats_byte_for_byte(play: Any) -> None:
    """The same messages at the same times give the same trace."""

    def digest() -> str:
        run = play(LOW, head())
        for value in (30.0, 25.0, 21.0, 19.0):
            receive(run, value)
            run.tick(3)
        assert run.status == "failure"
        return str(run.trace.sha256)

    assert digest() == digest()
