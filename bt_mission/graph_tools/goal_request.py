"""One goal sent by a person: from the wait for a server to the confirmed end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol

from bt_mission.goals.attempt import SERVER_CHECK_NS
from bt_mission.goals.goal import Goal, GoalClient, GoalStatus, Phase
from bt_mission.goals.ledger import Ledger

NS = 1_000_000_000
ANSWER_S = 5.0
"""How long a server may take to accept or reject."""

GRACE_S = 10.0
"""How long a goal may take to end once its cancel was asked for."""


QUIET_NS = NS
"""A server is often found within less, and nobody needs to be told of that."""


class GoalOutcome(StrEnum):
    """The closed list of ways in which a goal sent by hand ends."""

    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    CANCELED = "canceled"
    REJECTED = "rejected"
    NOT_SENT = "not sent"
    NO_SERVER = "no server"
    NO_ANSWER = "no answer"
    LOST = "lost"
    """Its server has gone, or knows it no longer."""
    UNCONFIRMED = "unconfirmed"
    """The cancel was not confirmed in time."""
    LEFT = "left"
    """Left at once, by a second Ctrl-C."""


@dataclass(frozen=True)
class GoalResult:
    """How it ended, why in one line for people, and the result where the server sent one."""

    how: GoalOutcome
    reason: str
    result: Any = None


class GoalListener(Protocol):
    """Told of what happens to the goal, each once."""

    def waiting(self, action: str) -> None:
        """There is no server yet."""

    def accepted(self, goal: Goal) -> None:
        """The server accepted it."""

    def feedback(self, message: Any, since_s: float) -> None:
        """Feedback came, so many seconds after the acceptance."""

    def canceling(self, why: str) -> None:
        """Its cancel has been asked for."""

    def refused(self) -> None:
        """The server refused to cancel; it is asked again."""

    def ended(self, end: GoalResult, since_s: float) -> None:
        """It has ended, so many seconds after the acceptance."""


class _Nobody:
    """Takes everything, and does nothing with it."""

    def waiting(self, action: str) -> None: ...
    def accepted(self, goal: Goal) -> None: ...
    def feedback(self, message: Any, since_s: float) -> None: ...
    def canceling(self, why: str) -> None: ...
    def refused(self) -> None: ...
    def ended(self, end: GoalResult, since_s: float) -> None: ...


class GoalRequest:
    """Sends one goal and sees it to its end.

    :param courier: the server.
    :param request: the goal, in the courier's form.
    :param audience: told what happens.
    :param seed: the goal's id is made from it.
    :param now_ns: of any clock that runs.
    :param server_s: how long to wait for a server.
    :param limit_s: after which the goal is cancelled; None is no limit.
    :param why_rejected: what the server's log says of a rejection; empty where it is not known.
    """

    def __init__(
        self,
        courier: GoalClient,
        request: Any,
        audience: GoalListener,
        seed: str,
        now_ns: int,
        *,
        server_s: float,
        limit_s: float | None = None,
        why_rejected: Callable[[], str] = str,
    ) -> None:
        self._courier = courier
        self._request = request
        self._audience = audience
        self._server_s = server_s
        self._limit_s = limit_s
        self._why_rejected = why_rejected
        self._rejected_ns: int | None = None
        self._ledger = Ledger(seed, round(GRACE_S * NS))
        self._since_ns = now_ns
        self._accepted_ns: int | None = None
        self._next_check_ns = now_ns
        self._why_cancel = ""
        self._was_told = {"waiting": False, "refused": False}
        self.goal: Goal | None = None
        self.end: GoalResult | None = None

    def poll(self, now_ns: int) -> GoalResult | None:
        """Move on; gives the end once there is one."""
        if self.end is None:
            end = self._send_when_ready(now_ns) if self.goal is None else self._tend(now_ns)
            self._finish(end, now_ns)
        return self.end

    def mute(self) -> None:
        """Tell nobody any more what happens."""
        self._audience = _Nobody()

    def cancel(self, why: str, now_ns: int) -> None:
        """Want it no more: asks the server to cancel; :meth:`poll` gives the end."""
        if self.end is not None or self._why_cancel:
            return
        if self.goal is None:
            self._finish(GoalResult(GoalOutcome.NOT_SENT, f"{why}; nothing was sent"), now_ns)
            return
        self._why_cancel = why
        self._audience.canceling(why)
        self._ledger.release_goal(self.goal, now_ns)

    def leave(self, why: str, now_ns: int) -> None:
        """End at once, whatever becomes of the goal; the end names it."""
        if self.end is None:
            left = "; ".join(self._ledger.describe_left_behind()) or "nothing was sent"
            self._finish(GoalResult(GoalOutcome.LEFT, f"{why}; left behind: {left}"), now_ns)

    # ---- one step per stage ----------------------------------------------------------------

    def _send_when_ready(self, now_ns: int) -> GoalResult | None:
        if self._courier.is_ready():
            self.goal = self._ledger.send(self._courier, "you", self._request, now_ns)
            self._since_ns = now_ns
        elif now_ns - self._since_ns >= self._server_s * NS:
            name = self._courier.name
            return GoalResult(
                GoalOutcome.NO_SERVER, f"no server of {name} after {self._server_s:g} s"
            )
        elif now_ns - self._since_ns >= QUIET_NS and not self._was_told["waiting"]:
            self._was_told["waiting"] = True
            self._audience.waiting(self._courier.name)
        return None

    def _tend(self, now_ns: int) -> GoalResult | None:
        goal = self.goal
        assert goal is not None
        if goal.accepted and self._accepted_ns is None:
            self._accepted_ns = now_ns
            self._audience.accepted(goal)
        if self._accepted_ns is not None:
            while goal.unread:
                self._audience.feedback(goal.unread.popleft(), self._since_s(now_ns))
        if goal.phase is Phase.ENDED:
            return self._read_end(goal, now_ns)
        if self._is_gone(now_ns):
            return GoalResult(
                GoalOutcome.LOST,
                f"{self._courier.name} has gone from the graph{self._left_behind()}",
            )
        if goal.cancel_refused and not self._was_told["refused"]:
            self._was_told["refused"] = True
            self._audience.refused()
        self._look_at_limits(goal, now_ns)
        self._ledger.update(now_ns)
        if goal.phase is Phase.LOST:
            return self._given_up()
        return None

    def _look_at_limits(self, goal: Goal, now_ns: int) -> None:
        if goal.phase is Phase.SENT and now_ns - self._since_ns >= ANSWER_S * NS:
            self.cancel(f"no answer within {ANSWER_S:g} s", now_ns)
        elif self._limit_s is not None and self._since_s(now_ns) >= self._limit_s:
            self.cancel(f"not done within {self._limit_s:g} s", now_ns)

    def _given_up(self) -> GoalResult:
        assert self.goal is not None
        if not self.goal.accepted:
            return GoalResult(
                GoalOutcome.NO_ANSWER, f"{self._courier.name} did not answer{self._left_behind()}"
            )
        words = "refused to cancel" if self.goal.cancel_refused else "did not confirm the cancel"
        return GoalResult(
            GoalOutcome.UNCONFIRMED,
            f"{self._courier.name} {words} within {GRACE_S:g} s{self._left_behind()}",
        )

    def _left_behind(self) -> str:
        return f"; left behind: {'; '.join(self._ledger.describe_left_behind())}"

    def _is_gone(self, now_ns: int) -> bool:
        if now_ns < self._next_check_ns:
            return False
        self._next_check_ns = now_ns + SERVER_CHECK_NS
        return not self._courier.is_ready()

    def _read_rejection(self, now_ns: int) -> GoalResult | None:
        """Rejected; the words of the server's log may still be on their way."""
        self._rejected_ns = self._rejected_ns or now_ns
        words = self._why_rejected()
        if not words and now_ns - self._rejected_ns < QUIET_NS:
            return None
        why = f"its log says: {words}" if words else "its log says why"
        return GoalResult(GoalOutcome.REJECTED, f"{self._courier.name} rejected the goal; {why}")

    def _read_end(self, goal: Goal, now_ns: int) -> GoalResult | None:
        name = self._courier.name
        if not goal.accepted:
            return self._read_rejection(now_ns)
        match goal.status:
            case GoalStatus.SUCCEEDED:
                return GoalResult(GoalOutcome.SUCCEEDED, "succeeded", goal.result)
            case GoalStatus.ABORTED:
                return GoalResult(GoalOutcome.ABORTED, f"{name} aborted the goal", goal.result)
            case GoalStatus.CANCELED:
                why = self._why_cancel or "by somebody else"
                return GoalResult(GoalOutcome.CANCELED, f"canceled: {why}", goal.result)
        return GoalResult(GoalOutcome.LOST, f"{name} no longer knows the goal (restarted?)")

    def _since_s(self, now_ns: int) -> float:
        return 0.0 if self._accepted_ns is None else (now_ns - self._accepted_ns) / NS

    def _finish(self, end: GoalResult | None, now_ns: int) -> None:
        if end is not None:
            self.end = end
            self._audience.ended(end, self._since_s(now_ns))
