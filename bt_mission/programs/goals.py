"""Goals of actions as their servers see them, while there are programs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

from rclpy.action import ActionClient, ActionServer
from rclpy.action import server as action_server
from rclpy.action.server import GoalEvent, ServerGoalHandle
from rclpy.node import Node
from rclpy.task import Future
from typing_extensions import override

from bt_mission.programs.executors import ProgramExecutor
from bt_mission.ros.executors.serving import ServingExecutor

WORDS = {
    GoalEvent.EXECUTE: "executing",
    GoalEvent.CANCEL_GOAL: "canceling",
    GoalEvent.SUCCEED: "succeeded",
    GoalEvent.ABORT: "aborted",
    GoalEvent.CANCELED: "canceled",
}
ENDS = ("rejected", "succeeded", "aborted", "canceled")


@dataclass(eq=False)
class ObservedGoal:
    """A goal, as far as it got.

    Attributes:
        action: The full name of the action.
        id: The UUID, in hexadecimal digits.
        request: The goal of the client.
        client: The name of the program whose client sent it; empty for others.
        server: The name of the program that has the server; empty for others.
        events: Time s, and one of ``requested``, ``accepted``, ``executing``, ``cancel requested``,
            ``canceling``, and the end: ``rejected``, ``succeeded``, ``aborted``, ``canceled``.
        feedback: Time s, and message.
    """

    action: str
    id: str
    request: Any
    client: str
    server: str
    events: list[tuple[float, str]] = field(default_factory=list)
    feedback: list[tuple[float, Any]] = field(default_factory=list)
    _result: Future | None = None

    @property
    def status(self) -> str:
        """The last event, but for requests to cancel."""
        return next(what for _, what in reversed(self.events) if what != "cancel requested")

    @property
    def accepted_s(self) -> float | None:
        """When it was accepted, s; None if it was not."""
        return self._time_of("accepted")

    @property
    def cancel_s(self) -> float | None:
        """When the server took the first request to cancel it, s; None without one."""
        return self._time_of("cancel requested")

    @property
    def ended_s(self) -> float | None:
        """When it ended, s; None if it has not."""
        return self._time_of(*ENDS)

    @property
    def result(self) -> Any:
        """The result; None before the execute callback has returned it."""
        response = self._result.result() if self._result is not None else None
        return None if response is None else response.result

    def _time_of(self, *events: str) -> float | None:
        return next((time_s for time_s, what in self.events if what in events), None)


class GoalHost(Protocol):
    """What the goals need of :class:`bt_mission.programs.host.ProgramHost`."""

    @property
    def time_s(self) -> float:
        """Virtual time since the start, s."""

    @property
    def nodes(self) -> list[Node]:
        """The nodes of all programs."""

    def name_of(self, node: Node) -> str:
        """Return the name of the program of a node; empty for others."""

    def action_of(self, server: ActionServer) -> str:
        """Return the full name of the action of a server."""


class ServedGoals:
    """The goals of all action servers on a clock, in the order of their requests."""

    def __init__(self, host: GoalHost) -> None:
        self._host = host
        self._by_id: dict[bytes, ObservedGoal] = {}

    @property
    def all(self) -> tuple[ObservedGoal, ...]:
        """All goals."""
        return tuple(self._by_id.values())

    def took(self, waitable: Any, parts: Any) -> None:
        """Note what an action server or client has taken."""
        if isinstance(waitable, ActionServer):
            if "goal" in parts:
                self._request(waitable, parts["goal"][1])
            if "cancel" in parts:
                self._cancel(parts["cancel"][1].goal_info)
        elif isinstance(waitable, ActionClient) and "goal" in parts:
            sequence, response = parts["goal"]
            goal_id = waitable._goal_sequence_number_to_goal_id.get(sequence)
            if goal_id is not None and not response.accepted:
                self.note(bytes(goal_id.uuid), "rejected")

    def _request(self, server: ActionServer, request: Any) -> None:
        node = server._node
        self._by_id[bytes(request.goal_id.uuid)] = ObservedGoal(
            self._host.action_of(server),
            bytes(request.goal_id.uuid).hex(),
            request.goal,
            self._client_of(request.goal_id),
            self._host.name_of(node),
            [(self._host.time_s, "requested")],
        )

    def _client_of(self, goal_id: Any) -> str:
        for node in self._host.nodes:
            for client in node.waitables:
                if isinstance(client, ActionClient):
                    pending = client._goal_sequence_number_to_goal_id
                    if goal_id in pending.values():
                        return self._host.name_of(node)
        return ""

    def _cancel(self, info: Any) -> None:
        """Note a request to cancel a goal, or all goals that are open."""
        goal_id = bytes(info.goal_id.uuid)
        for each, goal in self._by_id.items():
            if each == goal_id or (not any(goal_id) and goal.ended_s is None):
                self.note(each, "cancel requested")

    def note(self, goal_id: bytes, event: str) -> None:
        """Note an event of a goal."""
        if (goal := self._by_id.get(goal_id)) is not None:
            goal.events.append((self._host.time_s, event))

    def take_feedback(self, goal_id: bytes, message: Any) -> None:
        """Note feedback of a goal."""
        if (goal := self._by_id.get(goal_id)) is not None:
            goal.feedback.append((self._host.time_s, message))

    def expect_result(self, goal_id: bytes, result: Future | None) -> None:
        """Note where the result of a goal will be."""
        if (goal := self._by_id.get(goal_id)) is not None:
            goal._result = result


def _goals_of(server: ActionServer) -> ServedGoals | None:
    executor = server._node.executor
    if isinstance(executor, ProgramExecutor | ServingExecutor) and executor.host is not None:
        goals: ServedGoals = executor.host.goals
        return goals
    return None


class ObservedGoalHandle(ServerGoalHandle):
    """A goal of a server, whose events are noted."""

    def __init__(self, server: ActionServer, info: Any, request: Any) -> None:
        super().__init__(server, info, request)  # type: ignore[no-untyped-call]  # of rclpy
        self._note("accepted")

    @override
    def _update_state(self, event: Any) -> None:
        super()._update_state(event)  # type: ignore[no-untyped-call]  # of rclpy
        self._note(WORDS[event])
        if event in (GoalEvent.SUCCEED, GoalEvent.ABORT, GoalEvent.CANCELED):
            goal_id, server = bytes(self.goal_id.uuid), self._action_server
            if (goals := _goals_of(server)) is not None:
                goals.expect_result(goal_id, server._result_futures.get(goal_id))

    @override
    def publish_feedback(self, feedback: Any) -> None:
        super().publish_feedback(feedback)  # type: ignore[no-untyped-call]  # of rclpy
        if (goals := _goals_of(self._action_server)) is not None:
            goals.take_feedback(bytes(self.goal_id.uuid), feedback)

    def _note(self, event: str) -> None:
        if (goals := _goals_of(self._action_server)) is not None:
            goals.note(bytes(self.goal_id.uuid), event)


REPLACED = (action_server, {"ServerGoalHandle": ObservedGoalHandle})
"""The class of the goals of servers, while there are programs."""
