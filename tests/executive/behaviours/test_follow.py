"""Variables that follow topics: what they hold, from when, for how long, and who notices."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.support.play import message

NAN = float("nan")


def head(**keys: Any) -> str:
    """Return the head of a mission with one variable, `battery`."""
    more = "".join(f", {key}: {value}" for key, value in keys.items())
    follow = f"{{topic: /battery, type: a/msg/B, field: percentage, as: battery{more}}}"
    return f"mission: m\nfollow: {follow}"


def receive(run: Any, value: Any) -> None:
    """Publish a charge."""
    run.topics["/battery"].publish(percentage=value)


LOW = "  guard: battery > 20\n  do: {wait: 100}\n  name: charged"


def test_a_variable_holds_the_newest_value_of_its_topic(play: Any) -> None:
    """Of several messages between two ticks the last one counts."""
    run = play("  repeat: {count: 3}\n  do: {log: $battery %}", head())
    for values in ((80.0,), (79.0, 78.0, 77.5), ()):
        for value in values:
            receive(run, value)
        run.tick()
    assert run.logged == ["80 %", "77.5 %", "77.5 %"]
    assert run.status == "success"


def test_a_value_is_the_same_throughout_a_tick(play: Any) -> None:
    """A message that comes in the middle of a tick counts from the next one on."""
    leaves = "    - log: $battery\n" * 2
    run = play(f"  repeat: {{count: 2}}\n  do:\n   sequence:\n{leaves}", head())
    say = run.log

    def log(text: str) -> None:
        say(text)
        receive(run, 50.0)

    run.log = log
    receive(run, 80.0)
    run.tick(2)
    assert run.logged == ["80", "80", "50", "50"]


def test_a_guard_ends_its_node_at_the_next_tick(play: Any) -> None:
    """The reason shows the value."""
    run = play(LOW, head())
    receive(run, 21.0)
    assert run.tick(2) == "RR"
    receive(run, 20.0)
    assert run.tick() == "FI"
    assert run.executive.reason == "'charged' does not hold (battery = 20)"


@pytest.mark.parametrize("condition", ["$battery < 20", "battery < 20", "x > 9 or battery < 20"])
def test_a_goal_is_cancelled_by_its_condition_without_feedback(play: Any, condition: str) -> None:
    """With `$` or without it; beside a field of the feedback once there is feedback."""
    run = play(f"  turn: {{angle: 90}}\n  cancel_when: {condition}", head())
    receive(run, 21.0)
    run.tick()
    run.turn.accept()
    run.turn.feed(message(x=1.0))
    run.tick(2)
    assert run.turn.cancels == []
    receive(run, 19.0)
    run.tick()
    assert len(run.turn.cancels) == 1


def test_every_place_of_the_language_reads_it(play: Any) -> None:
    """Conditions, `set`, goals, limits, messages that are waited for, and texts."""
    run = play(
        "  sequence:\n    - check: battery > 20\n    - set: {twice: battery * 2}\n"
        "    - wait_for: {topic: /at, type: a/msg/B, until: x > $battery}\n"
        "    - log: ${battery:.1f} $twice\n    - turn: {angle: battery}\n      timeout: battery",
        head(),
    )
    receive(run, 40.0)
    run.tick()
    receive(run, 41.0)
    run.tick()
    run.topics["/at"].publish(x=40.5)
    assert run.tick()[:4] == "RSSR"
    run.topics["/at"].publish(x=41.5)
    run.tick(2)
    assert run.logged == ["41.0 80"]
    assert run.turn.requests[0]["angle"].as_value() == 41.0


def test_a_python_leaf_takes_it_as_an_input(
    play: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its value when the leaf is entered, each time."""
    (tmp_path / "level.py").write_text(
        "from py_trees.behaviour import Behaviour\nfrom py_trees.common import Status\n\n"
        "class Level(Behaviour):\n    level: float = 0.0\n    half: float = 0.0\n"
        "    def update(self):\n        self.half = self.level / 2\n"
        "        return Status.SUCCESS\n"
    )
    monkeypatch.chdir(tmp_path)
    leaf = "{python: 'level.py:Level', inputs: {level: $battery}, outputs: {half: half}}"
    tree = f"  repeat: {{count: 2}}\n  do: {{sequence: [{leaf}, {{log: $half}}]}}"
    run = play(tree, head())
    for value in (80.0, 60.0):
        receive(run, value)
        run.tick()
    assert run.logged == ["40", "30"]


def test_a_list_is_read_by_index(play: Any) -> None:
    """Arrays come as lists; each message makes conditions be asked again."""
    keys = "topic: /scan, type: a/msg/B, field: ranges, as: ranges"
    run = play(
        "  guard: min(ranges[0], ranges[-1]) > 1\n  do: {wait: 9}",
        f"mission: m\nfollow: {{{keys}}}",
    )
    run.topics["/scan"].publish(ranges=[2.0, 0.1, 3.0])
    assert run.tick(2) == "RR"
    run.topics["/scan"].publish(ranges=[2.0, 0.1, 0.9])
    assert run.tick() == "FI"


# ---- before the first message ------------------------------------------------------------------


def test_a_mission_begins_with_the_first_value(play: Any) -> None:
    """Until then no node is ticked; after a second it says what it waits for."""
    run = play(LOW, head())
    assert run.tick(20) == "II"
    assert run.logged == []
    run.tick()
    assert run.logged == [
        "the mission waits to begin: no message of /battery yet, it has no publisher"
    ]
    run.tick(20)
    assert len(run.logged) == 1
    assert run.executive.ticks == 0
    receive(run, 80.0)
    assert run.tick() == "RR"
    assert run.executive.ticks == 1


def test_a_topic_that_is_never_published_fails_the_mission(play: Any) -> None:
    """After five seconds, with the place, the reason, and what to do."""
    run = play(LOW, head())
    run.tick(100)
    assert run.status == "running"
    run.tick()
    assert run.status == "failure"
    assert run.executive.reason == (
        "<text>:2:9: 'battery' has no value after 5 s: no message of /battery yet, it has no "
        "publisher; start its publisher, or give it an 'initial' value [BT-913]"
    )


def test_a_longer_timeout_is_also_the_time_for_the_first_message(play: Any) -> None:
    """A shorter one is not: a graph takes its time to be found."""
    run = play(LOW, head(timeout=8))
    run.tick(160)
    assert run.status == "running"
    run.tick()
    assert "'battery' has no value after 8 s" in run.executive.reason
    run = play(LOW, head(timeout=0.5))
    assert run.tick(100) == "II"
    receive(run, 90.0)
    assert run.tick() == "RR"


def test_with_an_initial_value_a_mission_begins_at_once(play: Any) -> None:
    """It is the value until the first message, however long that takes."""
    run = play("  repeat: {count: 31}\n  do: {log: $battery}", head(initial=100, timeout=1))
    run.tick(30)
    receive(run, 80.0)
    run.tick()
    assert run.logged == 30 * ["100"] + ["80"]


def test_a_default_is_for_later(play: Any) -> None:
    """The mission waits for the first message all the same: `0` would end it at once."""
    run = play(LOW, head(default=0))
    assert run.tick(2) == "II"
    receive(run, 80.0)
    assert run.tick() == "RR"


def test_an_interrupted_wait_ends_the_mission(play: Any) -> None:
    """As any other does."""
    run = play(LOW, head())
    run.tick(10)
    run.executive.interrupt("Ctrl-C")
    run.tick()
    assert run.status == "interrupted"


# ---- without a value ---------------------------------------------------------------------------


def test_an_old_value_is_none(play: Any) -> None:
    """From the tick on at which it is as old as the timeout; who reads it fails the mission."""
    run = play(LOW, head(timeout=1))
    receive(run, 80.0)
    assert run.tick(19) == "RR"
    run.tick()
    assert run.status == "failure"
    assert run.executive.reason == (
        "<text>:4:3: 'charged' cannot start: 'battery' has no value: no message of "
        "/battery for 1 s (column 1) [BT-410]"
    )


def test_an_old_value_ends_a_goal_whose_condition_reads_it(play: Any) -> None:
    """A condition that cannot be answered protects nobody."""
    run = play("  turn: {angle: 90}\n  cancel_when: $battery < 20", head(timeout=1))
    receive(run, 80.0)
    run.tick()
    run.turn.accept()
    run.tick(20)
    assert "'$battery' has no value: no message of /battery for 1 s" in run.executive.reason
    assert len(run.turn.cancels) == 1


def test_an_old_value_that_nobody_reads_does_no_harm(play: Any) -> None:
    """And the next message ends its absence."""
    run = play("  sequence:\n    - wait: 3\n    - log: $battery", head(timeout=1))
    receive(run, 80.0)
    run.tick(50)
    receive(run, 60.0)
    run.tick(12)
    assert run.logged == ["60"]


def test_an_old_value_gives_way_to_the_default(play: Any) -> None:
    """So that the tree decides what follows from it."""
    run = play(LOW, head(timeout=1, default=0))
    receive(run, 80.0)
    run.tick(20)
    assert run.executive.reason == "'charged' does not hold (battery = 0)"


def test_what_is_not_a_number_is_no_value(play: Any) -> None:
    """No comparison with it would hold, whatever is asked."""
    run = play(LOW, head())
    receive(run, NAN)
    assert run.tick() == "II"
    receive(run, 80.0)
    assert run.tick() == "RR"
    receive(run, NAN)
    run.tick()
    assert "'battery' has no value: 'percentage' of /battery is not a number" in (
        run.executive.reason
    )


def test_a_message_without_the_field_is_no_value(play: Any) -> None:
    """Where nothing had checked the mission against its types."""
    run = play(LOW, head())
    run.topics["/battery"].publish(charge=1.0)
    run.tick(101)
    assert "messages of /battery have no field 'percentage'; give" in run.executive.reason


# ---- named trees, clean-ups, halts and pauses --------------------------------------------------

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
