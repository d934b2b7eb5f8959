"""One goal sent from the terminal: from the wait for a server to the confirmed end.

An :class:`~bt_mission.executive.goals.attempt.Attempt` ends when its leaf may continue, and leaves
the goal to the ledger. A request ends when the goal has ended, or nothing more can be known of it.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from bt_mission.base.stamps import NS
from bt_mission.commands.graph.goal_events import (
    CancelRefused,
    CancelRequested,
    FeedbackReceived,
    GoalAccepted,
    GoalEnded,
    GoalEvent,
    GoalOutcome,
    GoalResult,
    ServerAwaited,
)
from bt_mission.commands.graph.interface_description import describe_interface
from bt_mission.executive.goals.goal import FORGOTTEN, Goal, GoalClient, GoalStatus, Phase
from bt_mission.executive.goals.ledger import SERVER_CHECK_NS, Ledger
from bt_mission.executive.listeners import Stream
from bt_mission.ros.goal_client import RosGoalClient
from bt_mission.ros.server_logs import ServerLogs

if TYPE_CHECKING:
    from bt_mission.ros.graph_session import GraphSession

ANSWER_S = 5.0
"""The limit for a server to accept or reject."""

GRACE_S = 10.0
"""The limit for a goal to end once its cancel was requested."""

QUIET_NS = NS
"""A server is often discovered within less; the wait is then not reported."""


class GoalRequest:
    """Sends one goal and waits until it ends.

    Args:
        send: Called with each event, once.
        server_s: The limit of the wait for a server.
        limit_s: The goal is cancelled after this time; None is no limit.
    """

    def __init__(
        self,
        client: GoalClient,
        message: Any,
        send: Callable[[GoalEvent], None],
        *,
        server_s: float,
        limit_s: float | None = None,
    ) -> None:
        self._client = client
        self._message = message
        self._send = send
        self._server_s = server_s
        self._limit_s = limit_s
        self._ledger = Ledger(secrets.token_hex(8), round(GRACE_S * NS))
        self._since_ns: int | None = None
        self._accepted_ns: int | None = None
        self._rejected_ns: int | None = None
        self._next_check_ns = 0
        self._why_cancel = ""
        self._sent_once: set[GoalEvent] = set()
        self.goal: Goal | None = None
        self.end: GoalResult | None = None

    def poll(self, now_ns: int) -> GoalResult | None:
        """Advance, with the time of any running clock. Return the end once there is one."""
        if self._since_ns is None:
            self._since_ns = now_ns
        if self.end is None:
            wait_ns = now_ns - self._since_ns
            goal = self.goal
            end = self._find_server(now_ns, wait_ns) if goal is None else self._follow(goal, now_ns)
            if end is not None:
                self._finish(end, now_ns)
        return self.end

    def mute(self) -> None:
        """Stop reporting events."""
        self._send = lambda _: None

    def cancel(self, why: str, now_ns: int) -> None:
        """Ask the server to cancel; :meth:`poll` returns the end."""
        if self.end is not None or self._why_cancel:
            return
        if self.goal is None:
            self._finish(GoalResult(GoalOutcome.NOT_SENT, f"{why}; nothing was sent"), now_ns)
            return
        self._why_cancel = why
        self._send(CancelRequested(why))
        self._ledger.release_goal(self.goal, now_ns)

    def leave(self, why: str, now_ns: int) -> None:
        """End at once, whatever happens to the goal; the end names it."""
        if self.end is None:
            left = "; ".join(self._ledger.describe_left_behind()) or "nothing was sent"
            self._finish(GoalResult(GoalOutcome.LEFT, f"{why}; orphaned goal: {left}"), now_ns)

    # ---- one step per stage ----------------------------------------------------------------

    def _find_server(self, now_ns: int, wait_ns: int) -> GoalResult | None:
        name = self._client.name
        if self._client.is_ready():
            self.goal = self._ledger.send(self._client, "you", self._message, now_ns)
            self._since_ns = now_ns
        elif wait_ns >= self._server_s * NS:
            return GoalResult(
                GoalOutcome.NO_SERVER, f"no server of {name} after {self._server_s:g} s"
            )
        elif wait_ns >= QUIET_NS:
            self._send_once(ServerAwaited(name))
        return None

    def _follow(self, goal: Goal, now_ns: int) -> GoalResult | None:
        if goal.accepted:
            if self._accepted_ns is None:
                self._accepted_ns = now_ns
                self._send(GoalAccepted(goal.id.hex()))
            while goal.unread:
                self._send(FeedbackReceived(goal.unread.popleft(), self._since_s(now_ns)))
        if goal.phase is Phase.ENDED:
            return self._read_end(goal, now_ns)
        if self._is_gone(now_ns):
            return self._given_up(GoalOutcome.LOST, "has gone from the graph")
        if goal.cancel_refused:
            self._send_once(CancelRefused())
        self._check_limits(goal, now_ns)
        self._ledger.update(now_ns)
        if goal.phase is not Phase.LOST:
            return None
        if not goal.accepted:
            return self._given_up(GoalOutcome.NO_ANSWER, "did not answer")
        words = "refused to cancel" if goal.cancel_refused else "did not confirm the cancel"
        return self._given_up(GoalOutcome.UNCONFIRMED, f"{words} within {GRACE_S:g} s")

    def _check_limits(self, goal: Goal, now_ns: int) -> None:
        assert self._since_ns is not None
        if goal.phase is Phase.SENT and now_ns - self._since_ns >= ANSWER_S * NS:
            self.cancel(f"no answer within {ANSWER_S:g} s", now_ns)
        elif self._limit_s is not None and self._since_s(now_ns) >= self._limit_s:
            self.cancel(f"not done within {self._limit_s:g} s", now_ns)

    def _is_gone(self, now_ns: int) -> bool:
        if now_ns < self._next_check_ns:
            return False
        self._next_check_ns = now_ns + SERVER_CHECK_NS
        return not self._client.is_ready()

    def _read_end(self, goal: Goal, now_ns: int) -> GoalResult | None:
        name = self._client.name
        if not goal.accepted:
            return self._read_rejection(goal, now_ns)
        match goal.status:
            case GoalStatus.SUCCEEDED:
                return GoalResult(GoalOutcome.SUCCEEDED, "succeeded", goal.result)
            case GoalStatus.ABORTED:
                return GoalResult(GoalOutcome.ABORTED, f"{name} aborted the goal", goal.result)
            case GoalStatus.CANCELED:
                why = self._why_cancel or "by another client"
                return GoalResult(GoalOutcome.CANCELED, f"canceled: {why}", goal.result)
        return GoalResult(GoalOutcome.LOST, f"{name} {FORGOTTEN}")

    def _read_rejection(self, goal: Goal, now_ns: int) -> GoalResult | None:
        """Read the server's log line of the rejection, which may arrive later."""
        self._rejected_ns = self._rejected_ns or now_ns
        words = goal.refusal()
        if not words and now_ns - self._rejected_ns < QUIET_NS:
            return None
        why = f"its log says: {words}" if words else "its server gave no reason"
        return GoalResult(GoalOutcome.REJECTED, f"{self._client.name} rejected the goal; {why}")

    def _given_up(self, how: GoalOutcome, what: str) -> GoalResult:
        left = "; ".join(self._ledger.describe_left_behind())
        return GoalResult(how, f"{self._client.name} {what}; orphaned goal: {left}")

    def _since_s(self, now_ns: int) -> float:
        return 0.0 if self._accepted_ns is None else (now_ns - self._accepted_ns) / NS

    def _send_once(self, event: GoalEvent) -> None:
        if event not in self._sent_once:
            self._sent_once.add(event)
            self._send(event)

    def _finish(self, end: GoalResult, now_ns: int) -> None:
        self.end = end
        self._send(GoalEnded(end, self._since_s(now_ns)))


class GoalSender:
    """Sends goals of one action, and cancels one that takes longer than `limit_s`.

    Raises:
        BtMissionError: When the type is not installed, or the action has another one.
    """

    def __init__(
        self,
        session: GraphSession,
        action: str,
        type_name: str,
        *,
        server_s: float,
        limit_s: float | None = None,
    ) -> None:
        self.action = action
        self.about = describe_interface(type_name)
        self._server_s = server_s
        self._limit_s = limit_s
        logs = ServerLogs(session.node)
        logs.begin()
        self._client = RosGoalClient(session.node, action, type_name, logs.listen, Stream())

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """A goal message with these fields. Raises BtMissionError."""
        return self._client.prepare(fields)

    def open(self, message: Any, send: Callable[[GoalEvent], None]) -> GoalRequest:
        """Make a request that :meth:`GoalRequest.poll` sends and waits for."""
        return GoalRequest(
            self._client,
            message,
            send,
            server_s=self._server_s,
            limit_s=self._limit_s,
        )


def step_to_end(session: GraphSession, goal: GoalRequest) -> GoalResult:
    """Step until the goal has ended.

    The first Ctrl-C, and a closed output pipe, cancel the goal and wait for its end; a second
    Ctrl-C leaves at once.
    """
    signals = session.interrupts
    while True:
        try:
            if (end := goal.poll(session.now_ns)) is not None:
                return end
            if signals.count == 1:
                goal.cancel(f"interrupted by {signals.name}", session.now_ns)
            elif signals.count > 1:
                goal.leave(f"ended at once by a second {signals.name}", session.now_ns)
        except BrokenPipeError:
            goal.mute()
            goal.cancel("the output was closed", session.now_ns)
        session.step()
