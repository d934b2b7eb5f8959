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


def heard(story: Any, value: Any) -> None:
    """Publish a charge."""
    story.topics["/battery"].publish(percentage=value)


LOW = "  guard: battery > 20\n  do: {wait: 100}\n  name: charged"


def test_a_variable_holds_the_newest_value_of_its_topic(play: Any) -> None:
    """Of several messages between two ticks the last one counts."""
    story = play("  repeat: {count: 3}\n  do: {log: $battery %}", head())
    for values in ((80.0,), (79.0, 78.0, 77.5), ()):
        for value in values:
            heard(story, value)
        story.tick()
    assert story.said == ["80 %", "77.5 %", "77.5 %"]
    assert story.status == "success"


def test_a_value_is_the_same_throughout_a_tick(play: Any) -> None:
    """A message that comes in the middle of a tick counts from the next one on."""
    leaves = "    - log: $battery\n" * 2
    story = play(f"  repeat: {{count: 2}}\n  do:\n   sequence:\n{leaves}", head())
    say = story.log

    def log(text: str) -> None:
        say(text)
        heard(story, 50.0)

    story.log = log
    heard(story, 80.0)
    story.tick(2)
    assert story.said == ["80", "80", "50", "50"]


def test_a_guard_ends_its_node_at_the_next_tick(play: Any) -> None:
    """The reason shows the value."""
    story = play(LOW, head())
    heard(story, 21.0)
    assert story.tick(2) == "RR"
    heard(story, 20.0)
    assert story.tick() == "FI"
    assert story.executive.reason == "'charged' does not hold (battery = 20)"


@pytest.mark.parametrize("condition", ["$battery < 20", "battery < 20", "x > 9 or battery < 20"])
def test_a_goal_is_cancelled_by_its_condition_without_feedback(play: Any, condition: str) -> None:
    """With `$` or without it; beside a field of the feedback once there is feedback."""
    story = play(f"  turn: {{angle: 90}}\n  cancel_when: {condition}", head())
    heard(story, 21.0)
    story.tick()
    story.turn.accept()
    story.turn.feed(message(x=1.0))
    story.tick(2)
    assert story.turn.cancels == []
    heard(story, 19.0)
    story.tick()
    assert len(story.turn.cancels) == 1


def test_every_place_of_the_language_reads_it(play: Any) -> None:
    """Conditions, `set`, goals, limits, messages that are waited for, and texts."""
    story = play(
        "  sequence:\n    - check: battery > 20\n    - set: {twice: battery * 2}\n"
        "    - wait_for: {topic: /at, type: a/msg/B, until: x > $battery}\n"
        "    - log: ${battery:.1f} $twice\n    - turn: {angle: battery}\n      timeout: battery",
        head(),
    )
    heard(story, 40.0)
    story.tick()
    heard(story, 41.0)
    story.tick()
    story.topics["/at"].publish(x=40.5)
    assert story.tick()[:4] == "RSSR"
    story.topics["/at"].publish(x=41.5)
    story.tick(2)
    assert story.said == ["41.0 80"]
    assert story.turn.requests[0]["angle"].as_value() == 41.0


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
    story = play(tree, head())
    for value in (80.0, 60.0):
        heard(story, value)
        story.tick()
    assert story.said == ["40", "30"]


def test_a_list_is_read_by_index(play: Any) -> None:
    """Arrays come as lists; each message makes conditions be asked again."""
    keys = "topic: /scan, type: a/msg/B, field: ranges, as: ranges"
    story = play(
        "  guard: min(ranges[0], ranges[-1]) > 1\n  do: {wait: 9}",
        f"mission: m\nfollow: {{{keys}}}",
    )
    story.topics["/scan"].publish(ranges=[2.0, 0.1, 3.0])
    assert story.tick(2) == "RR"
    story.topics["/scan"].publish(ranges=[2.0, 0.1, 0.9])
    assert story.tick() == "FI"


# ---- before the first message ------------------------------------------------------------------


def test_a_mission_begins_with_the_first_value(play: Any) -> None:
    """Until then no node is ticked; after a second it says what it waits for."""
    story = play(LOW, head())
    assert story.tick(20) == "II"
    assert story.said == []
    story.tick()
    assert story.said == [
        "the mission waits to begin: no message of /battery yet, nobody publishes it"
    ]
    story.tick(20)
    assert len(story.said) == 1
    assert story.executive.ticks == 0
    heard(story, 80.0)
    assert story.tick() == "RR"
    assert story.executive.ticks == 1


def test_a_topic_that_is_never_published_fails_the_mission(play: Any) -> None:
    """After five seconds, with the place, the reason, and what to do."""
    story = play(LOW, head())
    story.tick(100)
    assert story.status == "running"
    story.tick()
    assert story.status == "failure"
    assert story.executive.reason == (
        "<text>:2:9: 'battery' has no value after 5 s: no message of /battery yet, nobody "
        "publishes it; start what publishes it, or give it an 'initial' value"
    )


def test_a_longer_timeout_is_also_the_time_for_the_first_message(play: Any) -> None:
    """A shorter one is not: a graph takes its time to be found."""
    story = play(LOW, head(timeout=8))
    story.tick(160)
    assert story.status == "running"
    story.tick()
    assert "'battery' has no value after 8 s" in story.executive.reason
    story = play(LOW, head(timeout=0.5))
    assert story.tick(100) == "II"
    heard(story, 90.0)
    assert story.tick() == "RR"


def test_with_an_initial_value_a_mission_begins_at_once(play: Any) -> None:
    """It is the value until the first message, however long that takes."""
    story = play("  repeat: {count: 31}\n  do: {log: $battery}", head(initial=100, timeout=1))
    story.tick(30)
    heard(story, 80.0)
    story.tick()
    assert story.said == 30 * ["100"] + ["80"]


def test_a_default_is_for_later(play: Any) -> None:
    """The mission waits for the first message all the same: `0` would end it at once."""
    story = play(LOW, head(default=0))
    assert story.tick(2) == "II"
    heard(story, 80.0)
    assert story.tick() == "RR"


def test_an_interrupted_wait_ends_the_mission(play: Any) -> None:
    """As any other does."""
    story = play(LOW, head())
    story.tick(10)
    story.executive.interrupt("Ctrl-C")
    story.tick()
    assert story.status == "interrupted"


# ---- without a value ---------------------------------------------------------------------------


def test_an_old_value_is_none(play: Any) -> None:
    """From the tick on at which it is as old as the timeout; who reads it fails the mission."""
    story = play(LOW, head(timeout=1))
    heard(story, 80.0)
    assert story.tick(19) == "RR"
    story.tick()
    assert story.status == "failure"
    assert story.executive.reason == (
        "<text>:4:3: 'charged' cannot start: 'battery' has no value: no message of "
        "/battery for 1 s (column 1)"
    )


def test_an_old_value_ends_a_goal_whose_condition_reads_it(play: Any) -> None:
    """A condition that cannot be answered protects nobody."""
    story = play("  turn: {angle: 90}\n  cancel_when: $battery < 20", head(timeout=1))
    heard(story, 80.0)
    story.tick()
    story.turn.accept()
    story.tick(20)
    assert "'$battery' has no value: no message of /battery for 1 s" in story.executive.reason
    assert len(story.turn.cancels) == 1


def test_an_old_value_that_nobody_reads_does_no_harm(play: Any) -> None:
    """And the next message ends its absence."""
    story = play("  sequence:\n    - wait: 3\n    - log: $battery", head(timeout=1))
    heard(story, 80.0)
    story.tick(50)
    heard(story, 60.0)
    story.tick(12)
    assert story.said == ["60"]


def test_an_old_value_gives_way_to_the_default(play: Any) -> None:
    """So that the tree decides what follows from it."""
    story = play(LOW, head(timeout=1, default=0))
    heard(story, 80.0)
    story.tick(20)
    assert story.executive.reason == "'charged' does not hold (battery = 0)"


def test_what_is_not_a_number_is_no_value(play: Any) -> None:
    """No comparison with it would hold, whatever is asked."""
    story = play(LOW, head())
    heard(story, NAN)
    assert story.tick() == "II"
    heard(story, 80.0)
    assert story.tick() == "RR"
    heard(story, NAN)
    story.tick()
    assert "'battery' has no value: 'percentage' of /battery is not a number" in (
        story.executive.reason
    )


def test_a_message_without_the_field_is_no_value(play: Any) -> None:
    """Where nothing had checked the mission against its types."""
    story = play(LOW, head())
    story.topics["/battery"].publish(charge=1.0)
    story.tick(101)
    assert "messages of /battery have no field 'percentage'; give" in story.executive.reason
