"""One goal as its leaf sees it: wait for the server, send, watch the limits, decide the outcome.

An attempt is made when a leaf starts and is never used again, so nothing that arrives late can
reach the leaf's next goal. :meth:`Attempt.poll` is called at every tick and looks, in this order,
at the result, the condition on feedback, and the limits: a result that arrives with the deadline
wins.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from operator import is_
from typing import Any

from bt_mission.base.actions import REPLACED
from bt_mission.base.stamps import NS
from bt_mission.executive.goals.goal import (
    FORGOTTEN,
    NO_CALLBACK,
    Goal,
    GoalClient,
    GoalStatus,
    Phase,
)
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.language.outcome import Outcome

REJECTED = "goal rejected: "
"""With which our own servers log a rejection."""


@dataclass(frozen=True)
class WatchedVariables:
    """The variables of a condition, which is judged again once one of them has changed.

    Attributes:
        values: Returns their values.
        needs_message: Whether the condition reads a message, too; else it is judged without one.
        condition: Looks at the newest feedback; returns what was met, or None.
    """

    values: Callable[[], Sequence[Any]]
    needs_message: bool
    condition: Callable[[Any], str | None]


@dataclass(frozen=True)
class Limits:
    """Limits of one attempt, in seconds of ROS time; None is no limit.

    Attributes:
        server: Wait for the server.
        answer: From the request to accepted or rejected.
        goal: From acceptance to the result.
        silence: Between two feedback messages.
        cancel: From a cancel request to the confirmed end.
        condition: Looks at each feedback; a text that says what was met cancels the goal.
        variables: Those of the condition: compared in each poll of a goal under way.
    """

    server: float = 5.0
    answer: float = 2.0
    goal: float | None = None
    silence: float | None = None
    cancel: float = 3.0
    condition: Callable[[Any], str | None] | None = None
    variables: WatchedVariables | None = None


@dataclass(frozen=True)
class AttemptResult:
    """The outcome of an attempt with its reason and result.

    Args:
        outcome: An item of the closed list.
        reason: One line that names the server, the limit or the condition.
        result: The result's fields, where the server sent one (also when canceled or aborted).
    """

    outcome: Outcome
    reason: str
    result: Any = None


class CancelCause(StrEnum):
    """The cause of a cancel request by the attempt."""

    CONDITION = "condition"
    TIMEOUT = "timeout"
    SILENCE = "silence"


_REPLACED = re.compile(rf"{REPLACED}: ([0-9a-f]{{8}}) of ")

_CANCELED = {
    CancelCause.CONDITION: Outcome.CANCELED_BY_CONDITION,
    CancelCause.TIMEOUT: Outcome.CANCELED_BY_TIMEOUT,
    CancelCause.SILENCE: Outcome.SILENT,
}


class Attempt:
    """The whole life of one goal, from the first wait for a server to one outcome.

    Args:
        goal_client: The client of the server.
        ledger: Keeps the goal beyond this attempt's end.
        owner: The leaf's name.
        request: The goal, in the client's form.
        limits: The limits that end it early.
        now_ns: ROS time, ns.
        uses: The parts of the robot that the goal moves. While another goal that moves one of them
            is ending, the goal is not sent.
        halted: Returns the goals that the tree halts in this tick, once the leaf runs.
    """

    def __init__(
        self,
        goal_client: GoalClient,
        ledger: Ledger,
        owner: str,
        request: Any,
        limits: Limits,
        now_ns: int,
        uses: frozenset[str] = frozenset(),
        halted: Callable[[], Iterable[Goal]] = tuple,
    ) -> None:
        self._goal_client = goal_client
        self._ledger = ledger
        self._owner = owner
        self._request = request
        self._limits = limits
        self._uses = uses
        self._halted = halted
        self._since_ns = now_ns
        self._received_ns = now_ns
        self._accepted_ns: int | None = None
        self._cancel_ns = 0
        self._cause: CancelCause | None = None
        self._cause_text = ""
        self._next_server_check_ns = now_ns
        self._due_ns = now_ns
        watched = limits.variables
        self._values = watched.values() if watched and watched.needs_message else None
        self.goal: Goal | None = None
        self.ending: AttemptResult | None = None

    @classmethod
    def of(cls, goal: Goal, ledger: Ledger, now_ns: int) -> Attempt:
        """The attempt that a goal, sent before, belongs to."""
        attempt = cls(goal.goal_client, ledger, goal.owner, None, Limits(), now_ns)
        attempt.goal = goal
        return attempt

    @property
    def feedback(self) -> Any:
        """The newest feedback of this goal, or None."""
        return self.goal.feedback if self.goal else None

    @property
    def stage(self) -> str:
        """The state of the attempt, as text."""
        if self.ending:
            return str(self.ending.outcome)
        if self.goal is None:
            return self.why_held or "waiting for the server"
        if self.goal.phase is Phase.SENT:
            return "waiting for acceptance"
        return "canceling" if self._cause else "active"

    @property
    def limits(self) -> Limits:
        """The limits that end it early, as they were computed at its beginning."""
        return self._limits

    @property
    def why_held(self) -> str:
        """Why the goal is not sent yet, even if there is a server; empty if it need not wait."""
        return "waiting for a clean-up" if self._ledger.is_held else self._awaited

    @property
    def _awaited(self) -> str:
        return self._ledger.awaited(self._goal_client, self._uses, self._halted())

    @property
    def is_decided(self) -> bool:
        """Whether the outcome is known, even if it has not been read yet."""
        has_ended = self.goal is not None and self.goal.phase is Phase.ENDED
        return self.ending is not None or has_ended

    def is_quiet(self, now_ns: int) -> bool:
        """Return whether nothing has arrived and no limit is due, so that a poll does nothing."""
        goal = self.goal
        return (
            now_ns < self._due_ns
            and self._limits.variables is None
            and goal is not None
            and goal.phase is Phase.ACTIVE
            and not goal.unread
            and self.ending is None
        )

    @property
    def limits_due(self) -> Mapping[str, int]:
        """The instants at which the limits under way are over, by the name of the limit.

        The wait for a server does not end while the goal is held.
        """
        limits, goal = self._limits, self.goal
        if self.is_decided:
            return {}
        running: dict[str, tuple[int | None, float | None]]
        if goal is None:
            if self._awaited:
                return {}
            running = {"server": (self._since_ns, limits.server)}
        elif goal.phase is Phase.SENT:
            running = {"answer": (self._since_ns, limits.answer)}
        elif self._cause is None:
            running = {"goal": (self._accepted_ns, limits.goal)}
            if self._accepted_ns is not None:
                running["silence"] = (self._received_ns, limits.silence)
        else:
            running = {"cancel": (self._cancel_ns, limits.cancel)}
        return {
            name: since_ns + math.ceil(limit_s * NS)
            for name, (since_ns, limit_s) in running.items()
            if since_ns is not None and limit_s is not None
        }

    @property
    def cause(self) -> CancelCause | None:
        """Why it has asked for its own goal to be cancelled; None where it has not."""
        return self._cause

    def move_goal_limit(self, due_ns: int) -> None:
        """Have the limit of an accepted goal be over at another instant, ns."""
        assert self._limits.goal is not None
        self._accepted_ns = due_ns - math.ceil(self._limits.goal * NS)
        self._due_ns = min(self._due_ns, due_ns)

    def poll(self, now_ns: int) -> AttemptResult | None:
        """Advance; return the result once the attempt has ended."""
        if self.ending is None:
            self.ending = self._advance(now_ns)
        return self.ending

    def halt(self, now_ns: int, reason: str = "halted by the tree") -> None:
        """End now. The ledger keeps the goal until it ends; nothing blocks."""
        if self.ending is not None:
            return
        self.ending = AttemptResult(Outcome.CANCELED_BY_HALT, reason)
        if self.goal is not None:
            self._ledger.release_goal(self.goal, now_ns)

    # ---- one step per stage ---------------------------------------------------------------

    def _advance(self, now_ns: int) -> AttemptResult | None:
        if self.goal is None:
            return self._wait_for_server(now_ns)
        if self.goal.phase is Phase.ENDED:
            return self._read_end(self.goal, now_ns)
        if self.goal.phase is Phase.SENT:
            return self._wait_for_answer(self.goal, now_ns)
        if self._accepted_ns is None:
            self._accepted_ns = self._received_ns = now_ns
        is_due = now_ns >= self._due_ns
        if is_due and self._server_is_gone(now_ns):
            self._ledger.release_goal(self.goal, now_ns)
            return AttemptResult(
                Outcome.SERVER_LOST, f"{self._goal_client.name} has gone from the graph"
            )
        if self._cause is None:
            self._check_feedback(self.goal, now_ns)
        if self._cause is None and is_due:
            self._check_limits(now_ns)
        if self._cause is None:
            if is_due:
                self._due_ns = self._next_due_ns(self._accepted_ns)
            return None
        return self._wait_for_cancel(self.goal, now_ns)

    def _wait_for_server(self, now_ns: int) -> AttemptResult | None:
        if self.why_held:
            self._since_ns = now_ns
            return None
        why = self._goal_client.obstacle()
        if not why and self._goal_client.is_ready():
            grace_ns = round(self._limits.cancel * NS)
            self.goal = self._ledger.send(
                self._goal_client, self._owner, self._request, now_ns, grace_ns, self._uses
            )
            self._since_ns = now_ns
            return None
        if now_ns - self._since_ns < self._limits.server * NS:
            return None
        text = why or f"{self._goal_client.name}: no server"
        return AttemptResult(Outcome.NO_SERVER, f"{text} after {self._limits.server:g} s")

    def _wait_for_answer(self, goal: Goal, now_ns: int) -> AttemptResult | None:
        if now_ns - self._since_ns < self._limits.answer * NS:
            return None
        self._ledger.release_goal(goal, now_ns)
        return AttemptResult(
            Outcome.NO_ANSWER,
            f"{self._goal_client.name} did not answer the goal within {self._limits.answer:g} s",
        )

    def _server_is_gone(self, now_ns: int) -> bool:
        if now_ns < self._next_server_check_ns:
            return False
        self._next_server_check_ns = now_ns + self._ledger.server_check_ns
        return not self._ledger.is_there(self._goal_client, now_ns)

    def _next_due_ns(self, accepted_ns: int) -> int:
        """The first instant at which the server or a limit is checked, rounded down, ns.

        Feedback that arrives earlier may put off the limit of silence; the check then finds it not
        due.
        """
        due_ns = self._next_server_check_ns
        for since_ns, limit_s in (
            (accepted_ns, self._limits.goal),
            (self._received_ns, self._limits.silence),
        ):
            if limit_s is not None:
                due_ns = min(due_ns, since_ns + math.floor(limit_s * NS))
        return due_ns

    def _check_feedback(self, goal: Goal, now_ns: int) -> None:
        condition = self._limits.condition
        if goal.unread:
            self._received_ns = now_ns
        while goal.unread:
            feedback = goal.unread.popleft()
            met = condition(feedback) if condition else None
            if met:
                self._cancel(CancelCause.CONDITION, met, now_ns)
                return
        watched = self._limits.variables
        if watched is not None and (met := self._met_anew(watched, goal.feedback)):
            self._cancel(CancelCause.CONDITION, met, now_ns)

    def _met_anew(self, watched: WatchedVariables, feedback: Any) -> str | None:
        """Return what the condition meets since a variable of it has changed."""
        if watched.needs_message and feedback is None:
            return None
        values = watched.values()
        if self._values is not None and all(map(is_, values, self._values)):
            return None
        self._values = values
        return watched.condition(feedback)

    def _check_limits(self, now_ns: int) -> None:
        limits, accepted_ns = self._limits, self._accepted_ns
        if (
            limits.goal is not None
            and accepted_ns is not None
            and now_ns - accepted_ns >= limits.goal * NS
        ):
            self._cancel(CancelCause.TIMEOUT, f"not done within {limits.goal:g} s", now_ns)
        elif limits.silence is not None and now_ns - self._received_ns >= limits.silence * NS:
            self._cancel(CancelCause.SILENCE, f"no feedback for {limits.silence:g} s", now_ns)

    def _cancel(self, cause: CancelCause, text: str, now_ns: int) -> None:
        assert self.goal is not None
        self._cause, self._cause_text, self._cancel_ns = cause, text, now_ns
        self._due_ns = now_ns
        self._ledger.cancel_goal(self.goal)

    def _wait_for_cancel(self, goal: Goal, now_ns: int) -> AttemptResult | None:
        why = f"{self._cause_text}, but {self._goal_client.name}"
        if goal.cancel_refused:
            self._ledger.release_goal(goal, now_ns)
            return AttemptResult(Outcome.CANCEL_REFUSED, f"{why} refused to cancel{NO_CALLBACK}")
        if now_ns - self._cancel_ns < self._limits.cancel * NS:
            return None
        self._ledger.release_goal(goal, now_ns)
        done = (
            "sent no result of the ended goal"
            if goal.lacks_result
            else "did not confirm the cancel"
        )
        return AttemptResult(Outcome.UNCONFIRMED, f"{why} {done} in {self._limits.cancel:g} s")

    def _read_end(self, goal: Goal, now_ns: int) -> AttemptResult:
        name, after = self._goal_client.name, self._after_cancel
        if not goal.accepted:
            why = (goal.refused or goal.refusal()).removeprefix(REJECTED)
            return AttemptResult(Outcome.REJECTED, f"{name}: {why or 'its server gave no reason'}")
        if goal.status is GoalStatus.SUCCEEDED:
            if self._cause is None:
                return AttemptResult(Outcome.SUCCEEDED, "succeeded", goal.result)
            late_s = (now_ns - (self._accepted_ns or now_ns)) / NS
            text = f"{name} succeeded {after}, {late_s:g} s after its acceptance"
            return AttemptResult(Outcome.SUCCEEDED_LATE, text, goal.result)
        if goal.status is GoalStatus.CANCELED:
            if self._cause is None:
                return AttemptResult(
                    Outcome.CANCELED_FROM_OUTSIDE, f"{name}: somebody else cancelled", goal.result
                )
            return AttemptResult(_CANCELED[self._cause], self._cause_text, goal.result)
        if goal.status is GoalStatus.ABORTED:
            why = f": {goal.raised}" if goal.raised else _say_error(goal.result)
            late = f", {after}" if after else ""
            text = f"{name}{why}{self._replacer(why)}{late}"
            return AttemptResult(Outcome.ABORTED, text, goal.result)
        return AttemptResult(Outcome.SERVER_LOST, f"{name} {FORGOTTEN}")

    def _replacer(self, why: str) -> str:
        """Return who has sent the goal that replaced this one, if it was not this mission."""
        by = _REPLACED.search(why)
        if by is None or self._ledger.has_sent(by[1]):
            return ""
        return f", sent by {self._ledger.others() or 'another client'}"

    @property
    def _after_cancel(self) -> str:
        """What came before the end of a goal that was to be canceled; empty for another one."""
        limits = self._limits
        match self._cause:
            case CancelCause.TIMEOUT:
                return f"after its timeout of {limits.goal:g} s"
            case CancelCause.SILENCE:
                return f"after {limits.silence:g} s without feedback"
            case CancelCause.CONDITION:
                return f"after its cancel condition was met ({self._cause_text})"
        return ""


def _say_error(result: Any) -> str:
    """The server's own code and message, where its result has Nav2's fields for them."""
    code = getattr(result, "error_code", None)
    message = getattr(result, "error_msg", "") or getattr(result, "error_string", "")
    if not code and not message:
        return ""
    if not code:
        return f": {message}"
    return f": {message} (code {code})" if message else f" with code {code}"
