"""Services, topics that are waited for, and topics that are published on."""

from __future__ import annotations

from typing import Any

import pytest

from tests.support.play import message

# ---- a call of a service -------------------------------------------------------------------------

CALL = "service: {name: /ask, type: std_srvs/srv/SetBool, request: {data: true}}"


def started(play: Any, modifiers: str = "") -> tuple[Any, Any]:
    """Tick once into a sequence of the call and a log."""
    run = play(f"  sequence:\n    - {CALL}\n{modifiers}    - log: done")
    run.tick()
    return run, run.services["/ask"]


@pytest.mark.parametrize(
    ("fields", "statuses", "reason"),
    [
        ({"success": True, "message": "ok"}, "SSS", ""),
        ({"sum": 3}, "SSS", ""),
        (
            {"success": False, "message": "no motor"},
            "FFI",
            "'ask' /ask: answered no success: no motor",
        ),
    ],
    ids=["success", "without a field of success", "no success, with the server's words"],
)
def test_the_answer_decides(play: Any, fields: dict[str, Any], statuses: str, reason: str) -> None:
    """One call, and no tick waits for it."""
    run, service = started(play)
    assert service.requests == [{"data": True}]
    assert run.tick(5) == "RRI"
    service.answer(**fields)
    assert (run.tick(), run.executive.reason) == (statuses, reason)
    assert (len(service.requests), service.forgotten) == (1, 0)


def test_outputs_are_written_from_every_response(play: Any) -> None:
    """Also from one that says no."""
    run = play(
        f"  sequence:\n    - fallback:\n        - {CALL}\n"
        "          outputs: {message: said}\n        - log: it said no\n    - log: $said"
    )
    run.tick()
    run.services["/ask"].answer(success=False, message="not now")
    run.tick()
    assert run.logged == ["it said no", "not now"]


def test_it_waits_for_the_server(play: Any) -> None:
    """Five seconds unless said otherwise; then it fails."""
    run = play(f"  {CALL}")
    service = run.services["/ask"]
    service.ready = False
    assert run.tick(100) == "R"
    assert run.root.feedback_message == "waiting for the server"
    assert run.tick() == "F"
    assert run.executive.reason == "'ask' /ask: no server after 5 s"
    assert service.requests == []


def test_a_server_that_comes_late_is_called(play: Any) -> None:
    """The time for the answer begins with the call."""
    run = play(f"  {CALL}\n  timeout: 1\n  server_timeout: 3")
    service = run.services["/ask"]
    service.ready = False
    run.tick(50)
    service.ready = True
    assert run.tick(20) == "R"
    service.answer(success=True, message="")
    assert run.tick() == "S"


@pytest.mark.parametrize(("modifiers", "seconds"), [("      timeout: 1\n", 1), ("", 5)])
def test_an_answer_that_does_not_come_fails_after_the_timeout(
    play: Any, modifiers: str, seconds: int
) -> None:
    """Exactly then, and the call is forgotten; an answer that comes with the deadline wins."""
    run, service = started(play, modifiers)
    assert run.tick(20 * seconds - 1) == "RRI"
    assert run.tick() == "FFI"
    assert run.executive.reason == f"'ask' /ask: no answer within {seconds} s"
    assert service.forgotten == 1
    run, service = started(play, modifiers)
    run.tick(20 * seconds - 1)
    service.answer(success=True, message="")
    assert run.tick() == "SSS"


def test_the_late_answer_of_a_halted_call_changes_nothing(play: Any) -> None:
    """Not in the next call of the same node either."""
    run = play(
        "  repeat: {count: 2}\n  do:\n    parallel:\n"
        f"      - {CALL}\n        outputs: {{message: said}}\n      - wait: 0.1\n"
        "    succeed_when: any"
    )
    run.tick(3)
    service = run.services["/ask"]
    assert service.forgotten == 1
    run.tick()
    assert len(service.requests) == 2
    service.answer(0, success=False, message="late")
    assert run.tick() == "RRRR"
    assert "said" not in run.scope.values
    service.answer(1, success=True, message="in time")
    run.tick()
    assert (run.status, run.scope.values["said"]) == ("success", "in time")


def test_requests_are_resolved_when_the_node_is_reached(play: Any) -> None:
    """With the variables of that moment."""
    text = "  service: {name: /add, type: a/srv/B, request: {a: $n, b: 'n + 1'}}\n  timeout: $n - 3"
    run = play(text, "mission: m\ninputs: {n: 5}")
    run.tick()
    (request,) = run.services["/add"].requests
    assert {key: part.as_value() for key, part in request.items()} == {"a": 5, "b": 6}


@pytest.mark.parametrize(("how", "status"), [("interrupt", "interrupted"), ("fail", "failure")])
def test_an_interrupted_mission_forgets_its_call(play: Any, how: str, status: str) -> None:
    """Nothing waits for the server."""
    run, service = started(play)
    getattr(run.executive, how)("enough")
    assert run.root.children[0].feedback_message == "halted"
    run.tick()
    assert (run.status, service.forgotten) == (status, 1)


# ---- a wait for a message ------------------------------------------------------------------------

WAIT = "wait_for: {topic: /battery, type: a/msg/B, until: percentage < $low}"
HEAD = "mission: m\ninputs: {low: 20}"


def test_a_wait_succeeds_at_the_tick_after_the_message(play: Any) -> None:
    """Not before one meets the condition; the reason shows the values that did."""
    run = play(f"  {WAIT}", HEAD)
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
        f"  sequence:\n    - {WAIT}\n      outputs: {{percentage: charge}}\n    - log: $charge %",
        HEAD,
    )
    run.tick()
    for value in (50.0, 12.0, 11.0, 90.0):
        run.topics["/battery"].publish(percentage=value)
    assert run.tick() == "SSS"
    assert run.logged == ["12 %"]


def test_messages_count_from_the_moment_the_node_is_reached(play: Any) -> None:
    """What came before is past."""
    run = play(f"  sequence:\n    - wait: 0.1\n    - {WAIT}", HEAD)
    run.tick()
    run.topics["/battery"].publish(percentage=5.0)
    assert run.tick(3) == "RSR"
    run.topics["/battery"].publish(percentage=5.0)
    assert run.tick() == "SSS"


def test_what_is_latched_counts_at_once(play: Any) -> None:
    """Also within the tick that reaches the node."""
    run = play("  wait_for: {topic: /on, type: std_msgs/msg/Bool, until: data}")
    run.topics["/on"].latched = message(data=True)
    assert run.tick() == "S"


def test_nested_fields_are_read_by_dotted_names(play: Any) -> None:
    """In the condition and in outputs; lists are shown by their length."""
    run = play(
        "  wait_for: {topic: /odom, type: a/msg/B, until: at.x > 1 and len(ranges) > 1}\n"
        "  outputs: {at.x: x}"
    )
    run.tick()
    run.topics["/odom"].publish(at=message(x=2.0), ranges=[1.0])
    assert run.tick() == "R"
    assert run.root.feedback_message == "at.x = 2, ranges of 1"
    run.topics["/odom"].publish(at=message(x=2.0), ranges=[1.0, 2.0])
    assert run.tick() == "S"
    assert run.scope.values == {"x": 2.0}


@pytest.mark.parametrize(
    ("charge", "reason"),
    [
        (None, "no message within 1 s; it has no publisher"),
        (88.0, "'percentage < $low' was not met within 1 s (last: percentage = 88)"),
    ],
)
def test_a_wait_fails_when_its_time_is_over(play: Any, charge: float | None, reason: str) -> None:
    """With the last values, or with what the graph knows when nothing came."""
    run = play(f"  {WAIT}\n  timeout: 1", HEAD)
    run.tick()
    if charge:
        run.topics["/battery"].publish(percentage=charge)
    assert run.tick(19) == "R"
    assert run.tick() == "F"
    assert run.executive.reason == f"'wait for battery' /battery: {reason}"


def test_a_message_that_comes_with_the_deadline_wins(play: Any) -> None:
    """As a result of a goal does."""
    run = play(f"  {WAIT}\n  timeout: 1", HEAD)
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
        f"  repeat: {{count: 2}}\n  do:\n    parallel:\n      - {WAIT}\n"
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


@pytest.mark.parametrize(
    ("leaf", "end"),
    [
        (f"fallback: [{{{CALL}, timeout: 0.1}}, {{wait: 9}}]", "/ask: no answer within 0.1 s"),
        (f"sequence: [{{{WAIT}}}, {{wait: 9}}]", "percentage < $low (percentage = 1)"),
    ],
    ids=["a call", "a wait"],
)
def test_what_has_ended_is_not_halted_when_its_parent_is(play: Any, leaf: str, end: str) -> None:
    """It keeps its last words, and a call is forgotten once."""
    run = play(f"  parallel: [{{{leaf}}}, {{wait: 0.3}}]\n  succeed_when: any", HEAD)
    run.tick()
    for topic in run.topics.values():
        topic.publish(percentage=1.0)
    run.tick(8)
    assert run.status == "success"
    assert run.root.children[0].children[0].feedback_message == end
    assert all(service.forgotten == 1 for service in run.services.values())


# ---- a message that is published -----------------------------------------------------------------

LAMP = "  publish: {topic: lamp, type: std_msgs/msg/Bool, message: {data: legs > 2}}"
LEGS = "mission: t\ninputs: {legs: 3}"


def test_it_publishes_once_somebody_listens(play: Any) -> None:
    """With the values of that moment, and only once."""
    run = play(LAMP, LEGS)
    lamp = run.speeches["lamp"]
    lamp.readers = 0
    assert run.tick() == "R"
    assert run.root.feedback_message == "nobody listens to lamp"
    assert lamp.published == []
    lamp.readers = 1
    assert run.tick() == "S"
    (published,) = lamp.published
    assert published["data"].as_value() is True
    assert run.root.feedback_message == "published to 1"


def test_it_fails_when_nobody_comes(play: Any) -> None:
    """After the server_timeout, exactly."""
    run = play(f"{LAMP}\n  readers: 2\n  server_timeout: 1", LEGS)
    assert run.tick(20) == "R"
    assert run.tick() == "F"
    assert run.executive.reason == "'publish lamp' 1 of 2 listen to lamp after 1 s"
    assert run.speeches["lamp"].published == []


def test_without_readers_it_does_not_wait(play: Any) -> None:
    """``readers: 0``."""
    run = play(f"{LAMP}\n  readers: 0", LEGS)
    run.speeches["lamp"].readers = 0
    assert run.tick() == "S"
    assert len(run.speeches["lamp"].published) == 1
    assert run.root.feedback_message == "published to nobody"
