"""An attempt turns what a server does, and when, into one outcome of the closed list."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from bt_mission.executive.goals.attempt import Attempt, Limits, WatchedVariables
from bt_mission.executive.goals.goal import NO_CALLBACK, GoalStatus
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.language.outcome import Outcome

S = 1_000_000_000
TICK = S // 20


class Run:
    """An attempt, its ledger and a clock that a test moves."""

    def __init__(self, server: Any, condition: Any = None, **limits: Any) -> None:
        self.now = S
        self.ledger = Ledger(seed=1, grace_ns=3 * S)
        self.attempt = Attempt(
            server,
            self.ledger,
            "turn left",
            {"angle": 90},
            Limits(condition=condition, **limits),
            self.now,
        )

    def tick(self, seconds: float = 0.05) -> Outcome | None:
        self.now += round(seconds * S)
        was_quiet, stage = self.attempt.is_quiet(self.now), self.attempt.stage
        ending = self.attempt.poll(self.now)
        if was_quiet:  # a leaf does not even ask
            assert (ending, self.attempt.stage) == (None, stage)
        self.ledger.update(self.now)
        return ending.outcome if ending else None

    @property
    def reason(self) -> str:
        assert self.attempt.ending is not None
        return self.attempt.ending.reason


@pytest.fixture
def run(server: Any) -> Run:
    """An attempt with the default limits."""
    return Run(server)


def accepted(run: Run, server: Any) -> None:
    """Bring a run to where its goal is active."""
    run.tick()
    server.accept()
    run.tick()


def test_a_goal_under_way_is_quiet_but_for_news_and_limits(server: Any) -> None:
    """Nothing is to be done in four ticks of five; what comes, or is due, is seen at once."""
    run = Run(server, goal=1.0)
    accepted(run, server)
    quiet = [run.attempt.is_quiet(run.now + number * TICK) for number in range(1, 21)]
    assert quiet == [True] * 4 + [False] * 16, "the server is looked for after 0.25 s"
    server.feed("feedback")
    assert not run.attempt.is_quiet(run.now + TICK)
    run.tick()
    for _ in range(18):
        run.tick()
    assert not run.attempt.is_quiet(run.now + TICK), "its limit"
    run.tick()
    server.cancel()
    assert run.tick() is Outcome.CANCELED_BY_TIMEOUT
    assert not run.attempt.is_quiet(run.now)


def test_an_attempt_that_is_put_back_judges_a_change_again(server: Any) -> None:
    """A proof puts it back, and tries another way: the values that it compares are its own."""
    variables = {"most": 9.0}
    watched = WatchedVariables(
        lambda: (variables["most"],), True, lambda way: "far" if way > variables["most"] else None
    )
    run = Run(server, variables=watched)
    accepted(run, server)
    server.feed(5.0)
    run.tick()
    before, less = dict(vars(run.attempt)), 1.0
    for _ in range(2):
        variables["most"] = 9.0
        vars(run.attempt).update(before)
        variables["most"] = less
        run.tick()
        assert run.attempt.stage == "canceling"


def test_success(run: Run, server: Any) -> None:
    """Sent, accepted, succeeded: the result comes with the ending and the ledger is empty."""
    accepted(run, server)
    assert server.requests == [{"angle": 90}]
    server.succeed("turned")
    assert run.tick() is Outcome.SUCCEEDED
    assert run.attempt.ending is not None
    assert run.attempt.ending.result == "turned"
    assert run.ledger.open_goals == ()


def test_rejected(run: Run, server: Any) -> None:
    """A rejection names the server, and says so where that gave no reason."""
    run.tick()
    server.reject()
    assert run.tick() is Outcome.REJECTED
    assert run.reason == "/turn: its server gave no reason"


BLOCKED = SimpleNamespace(error_code=906, error_msg="blocked")
FORGOTTEN = "/turn no longer knows the goal (it has restarted, or its result_timeout is 0)"


@pytest.mark.parametrize(
    ("status", "result", "outcome", "reason"),
    [
        (GoalStatus.ABORTED, BLOCKED, Outcome.ABORTED, "/turn: blocked (code 906)"),
        (
            GoalStatus.CANCELED,
            None,
            Outcome.CANCELED_FROM_OUTSIDE,
            "/turn: somebody else cancelled",
        ),
        (GoalStatus.UNKNOWN, None, Outcome.SERVER_LOST, FORGOTTEN),
    ],
)
def test_a_goal_may_end_otherwise(
    run: Run, server: Any, status: GoalStatus, result: Any, outcome: Outcome, reason: str
) -> None:
    """The server's own words stand in the reason; an unknown goal is no success."""
    accepted(run, server)
    server.goal.on_result(status, result)
    assert (run.tick(), run.reason) == (outcome, reason)


def test_no_server(run: Run, server: Any) -> None:
    """Without a server the attempt ends after the server limit, to the tick."""
    server.ready = False
    assert run.tick(4.999999999) is None
    assert run.tick(0.000000001) is Outcome.NO_SERVER
    assert run.reason == "/turn: no server after 5 s"
    assert server.goals == []


def test_a_server_that_comes_late_still_gets_the_goal(run: Run, server: Any) -> None:
    """The wait ends when the server appears."""
    server.ready = False
    run.tick(3)
    server.ready = True
    run.tick()
    assert len(server.goals) == 1


def test_no_answer_is_an_outcome_and_a_late_acceptance_is_cancelled(run: Run, server: Any) -> None:
    """After the answer limit the leaf gives up and cancels; accepted later, it cancels again."""
    run.tick()
    assert run.tick(1.999999999) is None
    assert run.tick(0.000000001) is Outcome.NO_ANSWER
    assert server.cancels == [server.goal]
    server.accept()
    assert server.cancels == [server.goal] * 2
    server.cancel()
    run.tick()
    assert run.ledger.open_goals == ()


def test_timeout(server: Any) -> None:
    """The goal limit counts from acceptance; the leaf stays until the cancel is confirmed."""
    run = Run(server, goal=30)
    accepted(run, server)
    assert run.tick(29.999999999) is None
    assert server.cancels == []
    assert run.tick(0.000000001) is None
    assert server.cancels == [server.goal]
    server.cancel("partial")
    assert run.tick() is Outcome.CANCELED_BY_TIMEOUT
    assert run.reason == "not done within 30 s"
    assert run.attempt.ending is not None
    assert run.attempt.ending.result == "partial"


@pytest.mark.parametrize("seconds", [0.1, 40])
def test_the_limit_of_a_goal_is_moved(server: Any, seconds: float) -> None:
    """It is over at the new instant, whether that is earlier or later."""
    run = Run(server, goal=2)
    accepted(run, server)
    due_ns = run.now + round(seconds * S)
    run.attempt.move_goal_limit(due_ns)
    assert run.attempt.limits_due == {"goal": due_ns}
    assert run.tick(seconds - 0.05) is None
    assert server.cancels == []
    run.tick()
    assert server.cancels == [server.goal]


def test_a_result_that_arrives_with_the_deadline_wins(server: Any) -> None:
    """Result first, then the condition, then the limits."""
    run = Run(server, goal=30)
    accepted(run, server)
    server.succeed()
    assert run.tick(30) is Outcome.SUCCEEDED
    assert server.cancels == []


def test_condition_on_feedback(server: Any) -> None:
    """The first feedback that meets the condition cancels, though a later one does not meet it."""
    run = Run(server, condition=lambda f: "over 2 m" if f > 2 else None)
    accepted(run, server)
    server.feed(1.9)
    run.tick()
    assert server.cancels == []
    server.feed(2.1)
    server.feed(0.0)
    run.tick()
    assert server.cancels == [server.goal]
    server.feed(2.2)
    run.tick()
    assert len(server.cancels) == 1
    server.cancel()
    assert run.tick() is Outcome.CANCELED_BY_CONDITION
    assert run.reason == "over 2 m"


@pytest.mark.parametrize("refuses", ["", "refuses"])
@pytest.mark.parametrize(
    ("limits", "why"),
    [
        ({"condition": lambda _: "met"}, "after its cancel condition was met (met)"),
        ({"goal": 2.0}, "after its timeout of 2 s"),
        ({"silence": 2.0}, "after 2 s without feedback"),
    ],
)
@pytest.mark.parametrize(
    ("ends", "outcome"),
    [("succeed", Outcome.SUCCEEDED_LATE), ("abort", Outcome.ABORTED)],
)
def test_an_end_after_the_cancel_names_what_came_before(
    server: Any, ends: str, outcome: Outcome, limits: dict[str, Any], why: str, refuses: str
) -> None:
    """The server may accept the cancel or not; a success after it is an outcome of its own."""
    run = Run(server, **limits)
    accepted(run, server)
    if "condition" in limits:
        server.feed(1)
    assert run.tick(2.0) is None
    assert server.cancels == [server.goal]
    if refuses:
        server.refuse_cancel()
    status = GoalStatus.SUCCEEDED if ends == "succeed" else GoalStatus.ABORTED
    server.goal.on_result(status, None)
    assert run.tick() is outcome
    after = ", 2.05 s after its acceptance" if ends == "succeed" else ""
    assert run.reason == f"/turn{',' if ends == 'abort' else ' succeeded'} {why}{after}"


def test_cancel_refused(server: Any) -> None:
    """A refused cancel is an outcome; the ledger asks again and the goal is not forgotten."""
    run = Run(server, condition=lambda f: "met")
    accepted(run, server)
    server.feed(1)
    run.tick()
    server.refuse_cancel()
    assert run.tick() is Outcome.CANCEL_REFUSED
    assert run.reason == f"met, but /turn refused to cancel{NO_CALLBACK}"
    assert len(server.cancels) == 2
    server.cancel()
    run.tick()
    assert run.ledger.open_goals == ()


def test_unconfirmed(server: Any) -> None:
    """A server that never confirms the cancel ends as unconfirmed, and is named at the end."""
    run = Run(server, goal=1, cancel=3)
    accepted(run, server)
    run.tick(1)
    assert run.tick(2.999999999) is None
    assert run.tick(0.000000001) is Outcome.UNCONFIRMED
    run.tick(3)
    (line,) = run.ledger.describe_left_behind()
    assert line == f"/turn goal {server.goal.short_id} of 'turn left' (lost)"


def test_silence(server: Any) -> None:
    """Feedback that stops is noticed; each feedback starts the wait anew."""
    run = Run(server, silence=2)
    accepted(run, server)
    run.tick(1.9)
    server.feed(1)
    run.tick(0.05)
    assert run.tick(1.999999999) is None
    assert server.cancels == []
    run.tick(0.000000001)
    server.cancel()
    assert run.tick() is Outcome.SILENT


def test_server_lost(run: Run, server: Any) -> None:
    """A server that leaves the graph is noticed within a quarter of a second."""
    accepted(run, server)
    server.ready = False
    assert run.tick(0.25) is Outcome.SERVER_LOST


def test_halt_while_waiting_for_the_answer(run: Run, server: Any) -> None:
    """The goal is asked to cancel at once, since the answer may be lost, and once accepted."""
    run.tick()
    run.attempt.halt(run.now)
    assert run.attempt.ending is not None
    assert run.attempt.ending.outcome is Outcome.CANCELED_BY_HALT
    assert server.cancels == [server.goal]
    server.accept()
    assert server.cancels == [server.goal] * 2


def test_halt_while_active_cancels_at_once(run: Run, server: Any) -> None:
    """The cancel request goes out within the halt itself, and the ledger sees the end."""
    accepted(run, server)
    run.attempt.halt(run.now)
    assert server.cancels == [server.goal]
    assert not run.ledger.is_settled
    server.cancel()
    run.ledger.update(run.now)
    assert run.ledger.is_settled


def test_halt_after_the_end_changes_nothing(run: Run, server: Any) -> None:
    """One ending, and only one."""
    accepted(run, server)
    server.succeed()
    run.tick()
    run.attempt.halt(run.now)
    assert run.attempt.ending is not None
    assert run.attempt.ending.outcome is Outcome.SUCCEEDED


def test_a_late_result_does_not_reach_the_next_attempt(server: Any) -> None:
    """The old goal's result lands in the old goal; the next waits until the server is free."""
    first = Run(server)
    accepted(first, server)
    old = server.goal
    first.attempt.halt(first.now)
    second = Attempt(server, first.ledger, "again", {}, Limits(), first.now)
    assert second.poll(first.now + TICK) is None
    assert len(server.goals) == 1, "not sent while the old goal lives"
    old.on_result(5, "old result")
    first.ledger.update(first.now + TICK)
    assert second.poll(first.now + 2 * TICK) is None
    assert len(server.goals) == 2
    assert second.feedback is None
    assert second.poll(first.now + 3 * TICK) is None


def test_an_earlier_goal_that_never_ends_is_awaited_until_it_is_given_up(server: Any) -> None:
    """The limit of the wait for the server begins after that."""
    ledger = Ledger(seed=1, grace_ns=60 * S)
    old = ledger.send(server, "old", {}, S)
    server.accept()
    ledger.release_goal(old, S)
    attempt = Attempt(server, ledger, "new", {}, Limits(), S)
    assert attempt.poll(61 * S) is None
    assert (attempt.stage, attempt.limits_due) == ("waiting for /turn of 'old' to end", {})
    ledger.update(61 * S)
    server.ready = False
    assert attempt.poll(62 * S) is None
    assert attempt.limits_due == {"server": 66 * S}
    ending = attempt.poll(66 * S)
    assert ending is not None
    assert ending.reason == "/turn: no server after 5 s"
