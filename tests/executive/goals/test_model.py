"""Ledger and attempts against a server that may do anything, in any order.

Hypothesis plays the server and the tree: it accepts late or never, answers twice, ends goals with
any status, refuses cancels, sends feedback at any time, vanishes, and halts leaves in between.
What is promised holds after every move.
"""

from __future__ import annotations

from typing import Any

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, invariant, precondition, rule

from bt_mission.executive.goals.attempt import Attempt, Limits
from bt_mission.executive.goals.goal import Goal, GoalTrigger, Phase
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.language.outcome import Outcome
from tests.conftest import ScriptedServer

S = 1_000_000_000
TICK_NS = S // 20
GRACE_S = 3.0


class Server(ScriptedServer):
    """An action server that does nothing by itself, and gets no goal beside an unwanted one."""

    def send(self, goal: Goal, request: Any) -> None:
        unwanted = [item for item in self.goals if item.is_live and item.orphaned_ns is not None]
        assert not unwanted, "a goal was sent while an earlier one may still run there"
        super().send(goal, request)


class Conversation(RuleBasedStateMachine):
    """One leaf that starts again whenever its attempt has ended, one server, one ledger."""

    goals = Bundle("goals")

    def __init__(self) -> None:
        super().__init__()
        self.now_ns = S
        self.server = Server()
        self.ledger = Ledger(1, round(GRACE_S * S))
        self.attempts: list[Attempt] = []
        self.endings: dict[int, Any] = {}
        self.answered: dict[bytes, bool] = {}
        self.ended: set[bytes] = set()
        self.begin()

    def begin(self) -> None:
        limits = Limits(
            server=2.0,
            answer=0.5,
            goal=4.0,
            silence=1.0,
            cancel=GRACE_S,
            condition=lambda feedback: "met" if feedback == "met" else None,
        )
        self.attempts.append(Attempt(self.server, self.ledger, "leaf", {}, limits, self.now_ns))

    @property
    def attempt(self) -> Attempt:
        return self.attempts[-1]

    # ---- the tree ------------------------------------------------------------------------

    @rule(target=goals, ticks=st.integers(1, 30))
    def tick(self, ticks: int) -> Any:
        """Let time pass; a new attempt begins where one has ended."""
        before = len(self.server.goals)
        for _ in range(ticks):
            self.now_ns += TICK_NS
            if self.attempt.ending is not None:
                self.begin()
            self.attempt.poll(self.now_ns)
            self.ledger.update(self.now_ns)
        return self.server.goals[-1] if len(self.server.goals) > before else None

    @rule()
    def halt(self) -> None:
        """The tree halts the leaf."""
        self.attempt.halt(self.now_ns)

    # ---- the server ----------------------------------------------------------------------

    @rule(goal=goals, accepted=st.booleans())
    def answer(self, goal: Goal | None, *, accepted: bool) -> None:
        """Accept or reject, late or once more: the middleware hands on the first answer alone."""
        if goal is not None and goal.id not in self.answered:
            self.answered[goal.id] = accepted
            goal.on(GoalTrigger.ACCEPTED if accepted else GoalTrigger.REJECTED)

    @rule(goal=goals, status=st.sampled_from([0, 1, 2, 4, 5, 6, 99]))
    def end(self, goal: Goal | None, status: int) -> None:
        """Send a result with any status, to a goal whose result was asked for."""
        if goal is not None and goal in self.server.results_asked:
            goal.on_result(status, "result")
            self.ended.add(goal.id)

    @rule(goal=goals)
    def refuse_cancel(self, goal: Goal | None) -> None:
        """Refuse to cancel."""
        if goal is not None and goal in self.server.cancels:
            goal.on(GoalTrigger.CANCEL_REFUSED)

    @rule(goal=goals, feedback=st.sampled_from(["some", "met"]))
    def feed(self, goal: Goal | None, feedback: str) -> None:
        """Send feedback of a goal, also of one that has ended or was never accepted."""
        if goal is not None:
            goal.on_feedback(feedback)

    @rule(ready=st.booleans())
    def come_and_go(self, *, ready: bool) -> None:
        """Vanish from the graph, or come back."""
        self.server.ready = ready

    # ---- the promises --------------------------------------------------------------------

    @invariant()
    def an_ending_never_changes(self) -> None:
        for index, attempt in enumerate(self.attempts):
            if attempt.ending is not None:
                assert self.endings.setdefault(index, attempt.ending) is attempt.ending
                assert isinstance(attempt.ending.outcome, Outcome)
                assert attempt.ending.reason

    @invariant()
    def every_goal_is_held_until_its_end_is_heard(self) -> None:
        held = {goal.id for goal in self.ledger.open_goals}
        for goal in self.server.goals:
            assert (goal.id in held) or goal.phase is Phase.ENDED
            if goal.phase is Phase.ENDED:
                assert goal.id in self.ended or self.answered.get(goal.id) is False

    @invariant()
    def what_nobody_wants_was_asked_to_stop(self) -> None:
        for goal in self.server.goals:
            if goal.orphaned_ns is not None and goal.accepted and goal.is_live:
                assert goal in self.server.cancels

    @invariant()
    def success_is_what_the_server_called_success(self) -> None:
        for attempt in self.attempts:
            ending = attempt.ending
            if ending is not None and ending.outcome is Outcome.SUCCEEDED:
                assert attempt.goal is not None
                assert attempt.goal.status == 4

    @precondition(lambda self: self.attempt.ending is None)
    @invariant()
    def nothing_lasts_for_ever(self) -> None:
        """With all four limits, an attempt ends within their sum, whatever the server does."""
        began = self.attempt._since_ns
        assert self.now_ns - began <= (2 + 0.5 + 4 + 1 + GRACE_S) * S + TICK_NS

    def teardown(self) -> None:
        """Whatever has happened: a halt and the grace bring everything to rest."""
        self.attempt.halt(self.now_ns)
        for goal in self.ledger.open_goals:
            self.ledger.release_goal(goal, self.now_ns)
        for _ in range(3):
            self.now_ns += round(GRACE_S * S)
            self.ledger.update(self.now_ns)
        assert self.ledger.is_settled
        left = {goal.id for goal in self.ledger.open_goals}
        assert left.isdisjoint(self.ended)
        assert len(self.ledger.describe_left_behind()) == len(left)


TestConversation = Conversation.TestCase
TestConversation.settings = settings(max_examples=75, stateful_step_count=40)
