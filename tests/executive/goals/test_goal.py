"""A goal's state machine does what its table says, and nothing else."""

from __future__ import annotations

import itertools

import pytest

from bt_mission.executive.goals.goal import Goal, GoalTrigger, Phase
from tests.conftest import ScriptedServer


class Requests(ScriptedServer):
    """A goal client that records its requests in their order."""

    def __init__(self) -> None:
        self.asked: list[str] = []

    def ask_result(self, goal: Goal) -> None:
        self.asked.append("result")

    def send_cancel(self, goal: Goal) -> None:
        self.asked.append("cancel")


def goal_in(phase: Phase) -> tuple[Goal, Requests]:
    """A goal in a phase, with the recorded requests of its client."""
    requests = Requests()
    return Goal(bytes(16), requests, "turn left", phase=phase), requests


# phase, event: next phase, requests; everything that is not here changes nothing.
TABLE = """
sent       accepted         active     result
sent       rejected         ended
sent       unwanted         recalled   cancel
sent       abandoned        lost
recalled   accepted         canceling  result cancel
recalled   rejected         ended
recalled   unwanted         recalled   cancel
recalled   abandoned        lost
active     unwanted         canceling  cancel
active     result           ended
active     abandoned        lost
canceling  cancel refused   active
canceling  unwanted         canceling  cancel
canceling  result           ended
canceling  abandoned        lost
lost       accepted         canceling  result cancel
lost       rejected         ended
lost       result           ended
"""


def expected(phase: Phase, event: GoalTrigger) -> tuple[str, list[str]]:
    """What the table above says of a pair."""
    for line in TABLE.strip().splitlines():
        if line.startswith(f"{phase:<11}{event:<17}"):
            next_phase, *requests = line[28:].split()
            return next_phase, requests
    return str(phase), []


@pytest.mark.parametrize(("phase", "event"), list(itertools.product(Phase, GoalTrigger)))
def test_each_event_in_each_phase_follows_the_table(phase: Phase, event: GoalTrigger) -> None:
    """Every pair, those that change nothing too."""
    goal, requests = goal_in(phase)
    goal.on(event)
    assert (str(goal.phase), requests.asked) == expected(phase, event)


def test_what_holds_in_every_order_of_arrival() -> None:
    """Of up to six events, repeated and out of place ones too: the promises of a goal's life."""
    for events in itertools.product(GoalTrigger, repeat=6):
        goal, requests = goal_in(Phase.SENT)
        messages: list[GoalTrigger] = []
        for event in events:
            before, asked = goal.phase, len(requests.asked)
            goal.on(event)
            messages.append(event)
            new = requests.asked[asked:]
            # What ended stays ended, and asks for nothing more.
            if before is Phase.ENDED:
                assert goal.phase is Phase.ENDED, messages
                assert not new, messages
            # It ends by an answer of the server, never by a wish of ours.
            if goal.phase is Phase.ENDED and before is not Phase.ENDED:
                assert event in (GoalTrigger.REJECTED, GoalTrigger.RESULT), messages
            # An acceptance is asked for its result at once, and once alone until it is given up.
            assert requests.asked.count("result") <= 1 + messages.count(GoalTrigger.GIVEN_UP), (
                messages
            )
            if goal.accepted:
                assert "result" in requests.asked, messages
            # Of a goal that was not accepted, nothing is asked but that it be cancelled.
            if not goal.accepted:
                assert "result" not in requests.asked, messages
            # A goal that nobody wants is asked to cancel, whether or not it has been answered.
            if GoalTrigger.UNWANTED in messages and goal.phase is not Phase.ENDED:
                assert "cancel" in requests.asked or GoalTrigger.GIVEN_UP in messages, messages
            # Only a wish, or an answer to one, cancels.
            if "cancel" in new:
                assert goal.phase in (Phase.RECALLED, Phase.CANCELING), messages
                assert event in (GoalTrigger.UNWANTED, GoalTrigger.ACCEPTED), messages
            # To be lost is not to be forgotten.
            if before is Phase.LOST and event is GoalTrigger.ACCEPTED:
                assert new == ["result", "cancel"], messages


def test_a_result_with_an_unknown_status_counts_as_unknown() -> None:
    """A server that answers with a status that is no final one does not count as success."""
    goal, _ = goal_in(Phase.ACTIVE)
    goal.on_result(2, "half")
    assert (goal.status, goal.phase) == (0, Phase.ENDED)


def test_feedback_may_overtake_the_acceptance() -> None:
    """It carries the goal's UUID, so it is this goal's; after the end it is dropped."""
    goal, _ = goal_in(Phase.SENT)
    goal.on_feedback("early")
    goal.on(GoalTrigger.ACCEPTED)
    goal.on_feedback("later")
    assert list(goal.unread) == ["early", "later"]
    goal.on_result(4, "done")
    goal.on_feedback("late")
    assert goal.feedback == "later"
