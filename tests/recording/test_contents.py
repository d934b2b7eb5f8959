"""What a recording holds of a run besides topics: its log, progress, goals, variables."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

from bt_mission.events.events import ClockJumped, StateChanged
from bt_mission.events.log import INFO, WARN, rosout_line
from tests.support.recorded_runs import Recorded, messages_for_others


def test_what_happens_between_two_ticks_is_said() -> None:
    """Pauses, and what was done to the clock."""
    paused, resumed = (StateChanged(1, "r", "m", word, "by hand") for word in ("paused", "running"))
    assert rosout_line(paused, ()) == (WARN, "paused: by hand")
    assert rosout_line(resumed, ()) == (INFO, "resumed")
    assert rosout_line(ClockJumped(1, -9.5), ()) == (WARN, "the ROS clock was set back by 9.5 s")
    assert rosout_line(ClockJumped(1, 100.0), ()) == (WARN, "the ROS clock skipped 100 s")


def details(run: Recorded) -> list[Any]:
    """The messages, as another reader has them."""
    return [
        messages_for_other
        for messages_for_other in messages_for_others(run.path)
        if messages_for_other.topic == "/bt_mission/details"
    ]


def test_progress_is_told_twice_a_second_and_when_something_happens(
    record: Callable[..., Recorded],
) -> None:
    """By the mission's clock."""
    messages = details(record())
    times = [message.time_ns for message in messages]
    assert all(0 <= after - before <= 550_000_000 for before, after in pairwise(times))
    values = [node.value for message in messages for node in message.message.running if node.limit]
    assert len(values) > 5


def test_the_first_message_has_everything(record: Callable[..., Recorded]) -> None:
    """Later ones have what has changed."""
    messages = details(
        record(
            text="mission: m\nworld: empty_arena\ninputs: {a: 1, b: two}\n"
            "tree:\n  sequence: [{set: {c: 2}}, {wait: 3}]\n"
        )
    )
    results = [
        [(variable.name, variable.value) for variable in each.message.variables]
        for each in messages
    ]
    assert ("b", '"two"') in results[0]
    assert sum(("b", '"two"') in result for result in results) == 1


def test_goals_are_told_with_each_state(record: Callable[..., Recorded]) -> None:
    """Until they have ended."""
    messages = details(record())
    states: dict[str, list[str]] = {}
    for message in messages:
        for goal in message.message.goals:
            states.setdefault(goal.owner, []).append(goal.state)
    assert [state[-1] for state in states.values()] == ["succeeded", "succeeded"]
    assert "active" in states["back"]


def test_a_closed_recorder_hears_no_more(record: Callable[..., Recorded]) -> None:
    """The mission has the subscribers that it had before."""
    run = record(steps=20)
    executive = run.stage.executive
    before = len(executive.events)
    run.recorder.close()
    assert len(executive.events) == before - 1
