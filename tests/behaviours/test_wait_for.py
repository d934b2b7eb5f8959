"""A wait for a message: which messages count, and when it ends."""

from __future__ import annotations

from typing import Any

BATTERY = "  wait_for: {topic: /battery, type: a/msg/B, until: percentage < $low}"
HEAD = "mission: m\ninputs: {low: 20}"


def test_it_succeeds_at_the_tick_after_the_message(play: Any) -> None:
    """Not before one meets the condition; the reason shows the values that did."""
    run = play(BATTERY, HEAD)
    assert run.tick(3) == "R"
    assert run.root.feedback_message == "no message yet"
    topic = run.topics["/battery"]
    topic.publish(percentage=50.0)
    assert run.tick() == "R"
    assert run.root.feedback_message == "percentage = 50"
    topic.publish(percentage=19.5)
    assert run.tick() == "S"
    assert run.root.feedback_message == "percentage < $low (percentage = 19.5)"
    assert topic.listeners == []


def test_the_condition_latches(play: Any) -> None:
    """A message between two ticks is enough, whatever comes after it; its fields are kept."""
    run = play(
        f"  sequence:\n    - {BATTERY.strip()}\n      outputs: {{percentage: charge}}\n"
        "    - log: $charge %",
        HEAD,
    )
    run.tick()
    for value in (50.0, 12.0, 11.0, 90.0):
        run.topics["/battery"].publish(percentage=value)
    assert run.tick() == "SSS"
    assert run.logged == ["12 %"]


def test_messages_count_from_the_moment_the_node_is_reached(play: Any) -> None:
    """What came before is past."""
    run = play(f"  sequence:\n    - wait: 0.1\n    - {BATTERY.strip()}", HEAD)
    run.tick()
    run.topics["/battery"].publish(percentage=5.0)
    assert run.tick(3) == "RSR"
    run.topics["/battery"].publish(percentage=5.0)
    assert run.tick() == "SSS"


def test_what_is_latched_counts_at_once(play: Any) -> None:
    """Also within the tick that reaches the node."""
    run = play("  wait_for: {topic: /on, type: std_msgs/msg/Bool, until: data}")
    run.topics["/on"].publish(data=True)
    run.topics["/on"].latched = type("Bool", (), {"data": True})
    assert run.tick() == "S"


def test_nested_fields_are_read_by_dotted_names(play: Any) -> None:
    """In the condition and in outputs."""
    run = play(
        "  wait_for: {topic: /odom, type: a/msg/B, until: at.x > 1 and not stale}\n"
        "  outputs: {at.x: x}"
    )
    run.tick()
    point = type("Point", (), {"x": 2.0})
    run.topics["/odom"].publish(at=point, stale=False)
    assert run.tick() == "S"
    assert run.scope.values == {"x": 2.0}


def test_it_fails_when_its_time_is_over(play: Any) -> None:
    """With the last values, or with what the graph knows when nothing came."""
    run = play(f"{BATTERY}\n  timeout: 1", HEAD)
    assert run.tick(20) == "R"
    assert run.tick() == "F"
    assert run.executive.reason == (
        "'wait for battery' /battery: no message within 1 s; it has no publisher"
    )
    run = play(f"{BATTERY}\n  timeout: 1", HEAD)
    run.tick()
    run.topics["/battery"].publish(percentage=88.0)
    assert run.tick(20) == "F"
    assert run.executive.reason == (
        "'wait for battery' /battery: 'percentage < $low' was not met within 1 s "
        "(last: percentage = 88)"
    )


def test_a_message_that_comes_with_the_deadline_wins(play: Any) -> None:
    """As a result of a goal does."""
    run = play(f"{BATTERY}\n  timeout: 1", HEAD)
    run.tick(20)
    run.topics["/battery"].publish(percentage=1.0)
    assert run.tick() == "S"


def test_a_condition_that_cannot_be_computed_fails_the_mission_with_its_place(play: Any) -> None:
    """At the next tick, not in the callback."""
    run = play("  wait_for: {topic: /a, type: a/msg/B, until: 1 / x > 2}")
    run.tick()
    run.topics["/a"].publish(x=0)
    run.topics["/a"].publish(x=1)
    run.tick(2)
    assert run.status == "failure"
    assert run.executive.reason.startswith("<text>:3:3: 'wait for a' until: division by zero")


def test_a_halted_wait_no_longer_listens_and_begins_anew(play: Any) -> None:
    """What it had heard is forgotten."""
    run = play(
        f"  repeat: {{count: 2}}\n  do:\n    parallel:\n      - {BATTERY.strip()}\n"
        "      - wait: 0.1\n    succeed_when: any",
        HEAD,
    )
    run.tick(2)
    topic = run.topics["/battery"]
    topic.publish(percentage=50.0)
    run.tick()
    assert topic.listeners == []
    topic.publish(percentage=1.0)
    assert run.tick() == "RRRR"
    topic.publish(percentage=1.0)
    run.tick()
    assert run.status == "success"


def test_lists_are_shown_by_their_length(play: Any) -> None:
    """A scan has hundreds of values."""
    run = play("  wait_for: {topic: /scan, type: a/msg/B, until: len(ranges) > 3}")
    run.tick()
    run.topics["/scan"].publish(ranges=[1.0, 2.0])
    run.tick()
    assert run.root.feedback_message == "ranges of 2"


def test_a_wait_that_has_ended_is_not_halted_when_its_parent_is(play: Any) -> None:
    """It keeps its last words."""
    run = play(
        f"  parallel:\n    - sequence:\n        - {BATTERY.strip()}\n        - wait: 9\n"
        "    - wait: 0.3\n  succeed_when: any",
        HEAD,
    )
    run.tick()
    run.topics["/battery"].publish(percentage=1.0)
    run.tick(8)
    assert run.status == "success"
    wait = run.root.children[0].children[0]
    assert wait.feedback_message == "percentage < $low (percentage = 1)"
