"""An action server that a test or a scenario plays, move by move.

It consists of the three services and two topics of an action instead of rclpy's action server, so
it can also do what a correct server never does: end a goal with an invalid status, send feedback of
another goal, or fall silent.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_action_status_default
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

from bt_mission.ros.interface_types import action_type, fill

DEPTH = 1024


@dataclass(eq=False)
class ScriptedGoal:
    """One goal at a :class:`ScriptedServer`; its methods are the server's moves.

    Args:
        request: The goal message.
        id: Its UUID, 16 bytes.
        cancels: How often somebody asked to cancel it, once it was accepted.
    """

    server: ScriptedServer
    request: Any
    id: bytes
    cancels: int = 0
    accepted: bool | None = None
    _answer: Future = field(default_factory=Future)
    _cancel_answers: list[Future] = field(default_factory=list)
    _end: Future = field(default_factory=Future)

    def accept(self) -> None:
        """Answer the goal: accepted."""
        self.answer(accepted=True)

    def reject(self) -> None:
        """Answer the goal: rejected."""
        self.answer(accepted=False)

    @property
    def has_ended(self) -> bool:
        """Has the server ended it?"""
        return bool(self._end.done())

    def answer(self, *, accepted: bool) -> None:
        """Answer the goal."""
        self.accepted = accepted
        self._answer.set_result(accepted)

    def feed(self, **fields: Any) -> None:
        """Send feedback; possible at any time, also before the answer and after the end."""
        self.server.feed(self.id, **fields)

    def answer_cancel(self, return_code: int = 0, *, taken: bool = True) -> None:
        """Answer every cancel request so far.

        Args:
            return_code: Of ``action_msgs/srv/CancelGoal``.
            taken: Is the goal among those that are canceling?
        """
        waiting, self._cancel_answers = self._cancel_answers, []
        for answer in waiting:
            answer.set_result((return_code, taken))

    def succeed(self, **fields: Any) -> None:
        """End it: succeeded, with these fields of the result."""
        self.end(GoalStatus.STATUS_SUCCEEDED, **fields)

    def cancel(self, **fields: Any) -> None:
        """End it: canceled."""
        self.end(GoalStatus.STATUS_CANCELED, **fields)

    def abort(self, **fields: Any) -> None:
        """End it: aborted."""
        self.end(GoalStatus.STATUS_ABORTED, **fields)

    def end(self, status: int, **fields: Any) -> None:
        """End it with any status, also an invalid one."""
        result = fill(self.server.type.Result(), fields)
        self._end.set_result((status, result))


class ScriptedServer:
    """Offers an action; every answer is a move of the test's, or a habit.

    Args:
        node: Owns the services and topics.
        type_name: Such as ``bt_mission_interfaces/action/Turn``.
        name: Of the action.
        accepts: Answer every goal at once: True accepts, False rejects, None waits for a move.
        cancels: Answer every cancel request at once: True takes it and ends the goal as canceled,
            False refuses it, None waits for a move.
    """

    def __init__(
        self,
        node: Node,
        type_name: str,
        name: str,
        *,
        accepts: bool | None = True,
        cancels: bool | None = True,
    ) -> None:
        self.type = action_type(type_name)
        self.type_name = type_name
        self.accepts = accepts
        self.cancels = cancels
        self.goals: list[ScriptedGoal] = []
        self._by_id: dict[bytes, ScriptedGoal] = {}
        self.name = name
        self.offer(node)

    def offer(self, node: Node) -> None:
        """Offer the action on a node; on another one after the server has died."""
        self.node = node
        impl, qos = self.type.Impl, QoSProfile(depth=DEPTH)
        at_once = ReentrantCallbackGroup()  # an answer that waits holds up no other
        name = self.name
        for service, part, callback in (
            (impl.SendGoalService, "send_goal", self._on_goal),
            (CancelGoal, "cancel_goal", self._on_cancel),
            (impl.GetResultService, "get_result", self._on_result),
        ):
            node.create_service(
                service, f"{name}/_action/{part}", callback, qos_profile=qos, callback_group=at_once
            )
        self._feedback = node.create_publisher(
            impl.FeedbackMessage, f"{name}/_action/feedback", qos
        )
        # An action has it; no client of ours reads it.
        node.create_publisher(
            GoalStatusArray, f"{name}/_action/status", qos_profile_action_status_default
        )

    @property
    def goal(self) -> ScriptedGoal:
        """The newest goal."""
        return self.goals[-1]

    def feed(self, goal_id: bytes, **fields: Any) -> None:
        """Send feedback under any goal's id."""
        message = self.type.Impl.FeedbackMessage()
        message.goal_id = UUID(uuid=list(goal_id))
        message.feedback = fill(self.type.Feedback(), fields)
        self._feedback.publish(message)

    def forget(self) -> None:
        """Know no goal any more, as after a restart."""
        self._by_id.clear()

    def on_goal(self, goal: ScriptedGoal) -> None:
        """Answer a goal by habit."""
        if self.accepts is not None:
            goal.answer(accepted=self.accepts)

    def on_cancel(self, goal: ScriptedGoal) -> None:
        """A cancel request waits for an answer."""

    async def _on_goal(self, request: Any, answer: Any) -> Any:
        goal = ScriptedGoal(self, request.goal, bytes(request.goal_id.uuid))
        self.goals.append(goal)
        self._by_id[goal.id] = goal
        self.on_goal(goal)
        answer.accepted = await goal._answer  # noqa: SLF001
        return answer

    async def _on_cancel(self, request: Any, answer: Any) -> Any:
        goal = self._by_id.get(bytes(request.goal_info.goal_id.uuid))
        if goal is None or not goal.accepted:
            answer.return_code = CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID
            return answer
        goal.cancels += 1
        taken = self.cancels
        if taken is None:
            waiting = Future()
            goal._cancel_answers.append(waiting)  # noqa: SLF001
            self.on_cancel(goal)
            answer.return_code, taken = await waiting
        elif taken:
            goal.cancel()
        else:
            answer.return_code = CancelGoal.Response.ERROR_REJECTED
        if taken:
            answer.goals_canceling = [GoalInfo(goal_id=UUID(uuid=list(goal.id)))]
        return answer

    async def _on_result(self, request: Any, answer: Any) -> Any:
        goal = self._by_id.get(bytes(request.goal_id.uuid))
        if goal is None:
            answer.status = GoalStatus.STATUS_UNKNOWN
            return answer
        answer.status, answer.result = await goal._end  # noqa: SLF001
        return answer
