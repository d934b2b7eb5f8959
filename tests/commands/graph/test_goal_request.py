"""The life of one goal sent by hand, against a server that answers when the test says so."""

from __future__ import annotations

from typing import Any

import pytest

from bt_mission.commands.graph import goal_events as events
from bt_mission.commands.graph.goal_events import GoalEvent, GoalOutcome
from bt_mission.commands.graph.goal_request import GoalRequest
from bt_mission.executive.goals.goal import FORGOTTEN

S = 1_000_000_000


class Record:
    """Keeps what is told, in words."""

    def __init__(self) -> None:
        self.reported: list[str] = []

    def tell(self, event: GoalEvent) -> None:
        match event:
            case events.ServerAwaited(action=action):
                self.reported.append(f"waiting {action}")
            case events.GoalAccepted():
                self.reported.append("accepted")
            case events.FeedbackReceived(message=message, since_s=since_s):
                self.reported.append(f"{message} {since_s:g}")
            case events.CancelRequested(why=why):
                self.reported.append(f"canceling {why}")
            case events.CancelRefused():
                self.reported.append("refused")
            case events.GoalEnded(end=end, since_s=since_s):
                self.reported.append(f"{end.how} {since_s:g}")


@pytest.fixture
def record() -> Record:
    """What was told."""
    return Record()


def opened(server: Any, record: Record, **options: Any) -> GoalRequest:
    """A goal that is not sent yet."""
    return GoalRequest(server, {"angle": 9}, record.tell, server_s=5.0, **options)


def running(server: Any, record: Record) -> GoalRequest:
    """A goal that the server has accepted at 0 s."""
    goal = opened(server, record)
    goal.poll(0)
    server.accept()
    goal.poll(0)
    return goal


def test_a_server_that_comes_late_is_waited_for(server: Any, record: Record) -> None:
    """People are told after a second; the goal is sent as soon as the server is there."""
    server.ready = False
    goal = opened(server, record)
    for now_s in (0.0, 0.9, 1.0, 1.1):
        assert goal.poll(round(now_s * S)) is None
    assert record.reported == ["waiting /turn"]
    server.ready = True
    goal.poll(2 * S)
    assert server.requests == [{"angle": 9}]


def test_feedback_that_overtakes_the_acceptance_is_told_after_it(
    server: Any, record: Record
) -> None:
    """In the order in which it came, each once."""
    goal = opened(server, record)
    goal.poll(0)
    server.feed("a")
    goal.poll(S)
    server.accept()
    server.feed("b")
    goal.poll(2 * S)
    goal.poll(3 * S)
    assert record.reported == ["accepted", "a 0", "b 0"]


def test_a_result_that_comes_with_feedback_ends_after_it(server: Any, record: Record) -> None:
    """Nothing that was said is lost."""
    goal = running(server, record)
    server.feed("last")
    server.goal.on_result(4, "result")
    end = goal.poll(3 * S)
    assert end is not None
    assert (end.how, end.result) == (GoalOutcome.SUCCEEDED, "result")
    assert record.reported == ["accepted", "last 3", "succeeded 3"]
    assert goal.poll(4 * S) is end


def test_a_refused_cancel_is_asked_again_each_second_until_the_grace_is_over(
    server: Any, record: Record
) -> None:
    """People are told once; in the end the goal is named."""
    goal = running(server, record)
    goal.cancel("because", S)
    goal.cancel("twice", S)
    end = None
    for tenth in range(10, 120):
        server.refuse_cancel()
        end = goal.poll(tenth * S // 10)
        if end:
            break
    assert end is not None
    assert end.how is GoalOutcome.UNCONFIRMED
    assert end.reason.startswith("/turn refused to cancel within 10 s; orphaned goal: /turn goal ")
    assert record.reported == ["accepted", "canceling because", "refused", "unconfirmed 11"]
    assert len(server.cancels) == 10


def test_a_cancel_that_nobody_confirms_ends_after_the_grace(server: Any, record: Record) -> None:
    """The goal is named."""
    goal = running(server, record)
    goal.cancel("because", S)
    assert goal.poll(10 * S) is None
    end = goal.poll(11 * S)
    assert end is not None
    assert end.how is GoalOutcome.UNCONFIRMED
    assert "did not confirm the cancel within 10 s" in end.reason


def test_a_server_that_never_answers(server: Any, record: Record) -> None:
    """After 5 s it is cancelled; should it be accepted yet, it is cancelled again."""
    goal = opened(server, record)
    goal.poll(0)
    goal.poll(5 * S)
    assert record.reported == ["canceling no answer within 5 s"]
    end = goal.poll(15 * S)
    assert end is not None
    assert end.how is GoalOutcome.NO_ANSWER
    assert end.reason.startswith("/turn did not answer; orphaned goal: /turn goal ")
    assert server.cancels == [server.goal]
    server.accept()
    assert server.cancels == [server.goal] * 2


def test_a_cancel_before_anything_was_sent_sends_nothing(server: Any, record: Record) -> None:
    """Ctrl-C while it waits for a server."""
    server.ready = False
    goal = opened(server, record)
    goal.poll(0)
    goal.cancel("interrupted", S)
    assert goal.end is not None
    assert goal.end.how is GoalOutcome.NOT_SENT
    assert goal.end.reason == "interrupted; nothing was sent"
    server.ready = True
    goal.poll(2 * S)
    assert server.requests == []


def test_a_server_without_memory_has_lost_the_goal(server: Any, record: Record) -> None:
    """Its result has a status that is none."""
    goal = running(server, record)
    server.goal.on_result(0, None)
    end = goal.poll(S)
    assert end is not None
    assert end.how is GoalOutcome.LOST
    assert end.reason == f"/turn {FORGOTTEN}"


def test_the_words_of_a_rejection_are_waited_for_a_second(server: Any, record: Record) -> None:
    """They come another way than the answer."""
    words: list[str] = []
    goal = opened(server, record)
    goal.poll(0)
    server.goal.refusal = lambda: "".join(words)
    server.reject()
    assert goal.poll(S // 2) is None
    words.append("too fast")
    end = goal.poll(S)
    assert end is not None
    assert end.how is GoalOutcome.REJECTED
    assert end.reason == "/turn rejected the goal; its log says: too fast"


def test_a_muted_goal_tells_nobody(server: Any, record: Record) -> None:
    """As when the reader of our output has left."""
    goal = opened(server, record)
    goal.poll(0)
    server.accept()
    goal.mute()
    server.feed("unheard")
    goal.cancel("nobody reads", S)
    server.goal.on_result(5, None)
    assert goal.poll(2 * S) is not None
    assert record.reported == []
