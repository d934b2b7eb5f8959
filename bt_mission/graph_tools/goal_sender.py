"""Sends goals of one action and steps until they have ended."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from bt_mission.graph_tools.goal_request import GoalRequest
from bt_mission.graph_tools.interface_description import describe_interface
from bt_mission.ros.goal_client import RosGoalClient
from bt_mission.ros.server_logs import ServerLogs

if TYPE_CHECKING:
    from bt_mission.graph_tools.goal_events import GoalEvent, GoalResult
    from bt_mission.graph_tools.graph_session import GraphSession


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
        self._client = RosGoalClient(session.node, action, type_name, logs.listen)
        self._why_rejected = logs.listen(self._client.name)

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """A goal message with these fields. Raises BtMissionError."""
        return self._client.prepare(fields)

    def open(self, message: Any, tell: Callable[[GoalEvent], None]) -> GoalRequest:
        """Make a request that :meth:`GoalRequest.poll` sends and sees to its end."""
        return GoalRequest(
            self._client,
            message,
            tell,
            server_s=self._server_s,
            limit_s=self._limit_s,
            why_rejected=self._why_rejected,
        )


def step_to_end(session: GraphSession, goal: GoalRequest) -> GoalResult:
    """Step until the goal has ended.

    The first Ctrl-C, and a reader of our output that leaves, cancel the goal and wait for its end;
    a second Ctrl-C leaves at once.
    """
    signals = session.interrupts
    while True:
        try:
            if (end := goal.poll(session.now_ns)) is not None:
                return end
            if signals.count == 1:
                goal.cancel(f"interrupted by {signals.name}", session.now_ns)
            elif signals.count > 1:
                goal.leave(f"left at once after a second {signals.name}", session.now_ns)
        except BrokenPipeError:
            goal.mute()
            goal.cancel("nobody reads the output any more", session.now_ns)
        session.step()
