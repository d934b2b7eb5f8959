"""A call of a service: when it is sent, and what its answer, or none, comes to."""

from __future__ import annotations

from typing import Any

import pytest

CALL = "  service: {name: /ask, type: std_srvs/srv/SetBool, request: {data: true}}"


def started(play: Any, modifiers: str = "") -> tuple[Any, Any]:
    """Tick once into a sequence of the call and a log that reads an output."""
    text = f"  sequence:\n    - {CALL.strip()}\n{modifiers}    - log: done"
    run = play(text)
    run.tick()
    return run, run.services["/ask"]


def test_the_answer_makes_it_succeed(play: Any) -> None:
    """One call, and no tick waits for it."""
    run, service = started(play)
    assert service.requests == [{"data": True}]
    assert run.tick(5) == "RRI"
    service.answer(success=True, message="ok")
    assert run.tick() == "SSS"
    assert len(service.requests) == 1
    assert service.forgotten == 0


def test_an_answer_without_a_field_of_success_is_a_success(play: Any) -> None:
    """Not every service is like Trigger."""
    run, service = started(play)
    service.answer(sum=3)
    assert run.tick() == "SSS"


def test_no_success_is_a_failure_with_the_servers_words(play: Any) -> None:
    """The response's message is the reason."""
    run, service = started(play)
    service.answer(success=False, message="no motor")
    assert run.tick() == "FFI"
    assert run.executive.reason == "'ask' /ask: answered no success: no motor"


def test_outputs_are_written_from_every_response(play: Any) -> None:
    """Also from one that says no."""
    run = play(
        f"  sequence:\n    - fallback:\n        - {CALL.strip()}\n"
        "          outputs: {message: said}\n        - log: it said no\n    - log: $said"
    )
    run.tick()
    run.services["/ask"].answer(success=False, message="not now")
    run.tick()
    assert run.logged == ["it said no", "not now"]


def test_it_waits_for_the_server(play: Any) -> None:
    """Five seconds unless said otherwise; then it fails."""
    run = play(CALL)
    service = run.services["/ask"]
    service.ready = False
    assert run.tick(100) == "R"
    assert run.root.feedback_message == "waiting for the server"
    assert run.tick() == "F"
    assert run.executive.reason == "'ask' /ask: no server after 5 s"
    assert service.requests == []


def test_a_server_that_comes_late_is_called(play: Any) -> None:
    """The time for the answer begins with the call."""
    run = play(f"{CALL}\n  timeout: 1\n  server_timeout: 3")
    service = run.services["/ask"]
    service.ready = False
    run.tick(50)
    service.ready = True
    assert run.tick(20) == "R"
    service.answer(success=True, message="")
    assert run.tick() == "S"


def test_an_answer_that_does_not_come_fails_after_the_timeout(play: Any) -> None:
    """Exactly then, and the call is forgotten."""
    run, service = started(play, "      timeout: 1\n")
    assert run.tick(19) == "RRI"
    assert run.tick() == "FFI"
    assert run.executive.reason == "'ask' /ask: no answer within 1 s"
    assert service.forgotten == 1


def test_an_answer_that_comes_with_the_deadline_wins(play: Any) -> None:
    """As a result of a goal does."""
    run, service = started(play, "      timeout: 1\n")
    run.tick(19)
    service.answer(success=True, message="")
    assert run.tick() == "SSS"


def test_the_late_answer_of_a_halted_call_changes_nothing(play: Any) -> None:
    """Not in the next call of the same node either."""
    run = play(
        "  repeat: {count: 2}\n  do:\n    parallel:\n"
        f"      - {CALL.strip()}\n        outputs: {{message: said}}\n      - wait: 0.1\n"
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
    assert run.status == "success"
    assert run.scope.values["said"] == "in time"


def test_requests_are_resolved_when_the_node_is_reached(play: Any) -> None:
    """With the variables of that moment; a value that is missing fails the mission."""
    text = "  service: {name: /add, type: a/srv/B, request: {a: $n, b: 'n + 1'}}\n  timeout: $n - 3"
    run = play(text, "mission: m\ninputs: {n: 5}")
    run.tick()
    (request,) = run.services["/add"].requests
    assert {key: part.as_value() for key, part in request.items()} == {"a": 5, "b": 6}


@pytest.mark.parametrize("how", ["interrupt", "fail"])
def test_an_interrupted_mission_forgets_its_call(play: Any, how: str) -> None:
    """Nothing waits for the server."""
    run, service = started(play)
    getattr(run.executive, how)("enough")
    assert run.root.children[0].feedback_message == "halted"
    run.tick()
    assert run.status == ("interrupted" if how == "interrupt" else "failure")
    assert service.forgotten == 1


def test_a_call_that_has_ended_is_not_halted_when_its_parent_is(play: Any) -> None:
    """It keeps its last words, and is forgotten once."""
    run = play(
        f"  parallel:\n    - fallback:\n        - {CALL.strip()}\n          timeout: 0.1\n"
        "        - wait: 9\n    - wait: 0.3\n  succeed_when: any"
    )
    run.tick(8)
    assert run.status == "success"
    call = run.root.children[0].children[0]
    assert call.feedback_message == "/ask: no answer within 0.1 s"
    assert run.services["/ask"].forgotten == 1
