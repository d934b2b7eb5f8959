"""The thin layer between a goal and rclpy's action client."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient, get_action_names_and_types
from rclpy.action.client import ClientGoalHandle
from rclpy.node import Node
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

from bt_mission.executive.goals.goal import Goal, GoalStatus, GoalTrigger, Phase
from bt_mission.executive.listeners import Stream
from bt_mission.ros.clients import RosClient
from bt_mission.ros.executors.action_endpoints import duplicate_servers, qos_conflict
from bt_mission.ros.executors.serving import ServingExecutor
from bt_mission.ros.graph import REQUESTS
from bt_mission.ros.interface_types import action_type
from bt_mission.ros.virtual_time import VirtualTimeExecutor


@dataclass(frozen=True)
class Exchange:
    """A request to one of the three services of an action, or its response.

    Args:
        action: Resolved name of the action; ``type_name`` is its type.
        service: ``send_goal``, ``cancel_goal`` or ``get_result``.
        goal_id: The goal of the request.
        request: The request.
        answer: The response; None for the request.
    """

    action: str
    type_name: str
    service: str
    goal_id: bytes
    request: Any
    answer: Any = None


class _Client(ActionClient):
    """Receives the first response to a goal; rclpy raises an error for a simultaneous second one.

    DDS delivers responses for other clients of the server here, too. Many of them do not displace
    ours.
    """

    def __init__(self, node: Node, action: type, name: str) -> None:
        super().__init__(  # type: ignore[no-untyped-call]  # rclpy's
            node,
            action,
            name,
            goal_service_qos_profile=REQUESTS,
            result_service_qos_profile=REQUESTS,
            cancel_service_qos_profile=REQUESTS,
        )

    async def execute(self, taken_data: dict[str, Any]) -> None:
        """Handle what was received."""
        if len(taken_data) == 1 and "feedback" in taken_data:  # nearly all arrivals
            message = taken_data["feedback"]
            goal_id = bytes(message.goal_id.uuid)
            if goal_id in self._feedback_callbacks:
                self._feedback_callbacks[goal_id](message)
            return
        if "goal" in taken_data:
            pending = self._pending_goal_requests.get(taken_data["goal"][0])
            if pending is not None and pending.done():
                del taken_data["goal"]
        await super().execute(taken_data)  # type: ignore[no-untyped-call]  # rclpy's


class RosGoalClient(RosClient):
    """Sends goals of one action to its server and returns the responses.

    Args:
        node: The node of the action client.
        name: The action's name; resolved against the node's namespace.
        type_name: Such as ``bt_mission_interfaces/action/Turn``.
        listen: Called with the resolved name when a goal is sent; returns a reader of the reason of
            a rejection, empty if it is not known.
        exchanges: Emits each request when it is sent, and once more when it is answered.
        warn: Takes that the action has several servers, to which goals are sent nevertheless; None
            sends them none.

    Raises:
        BtMissionError: When the type is not installed, or the action has another one.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        type_name: str,
        listen: Callable[[str], Callable[[], str]],
        exchanges: Stream[Exchange],
        warn: Callable[[str], None] | None = None,
    ) -> None:
        self._listen = listen
        self._exchanges = exchanges
        self._type, full = action_type(type_name), node.resolve_topic_name(name)
        super().__init__(node, full, type_name, self._type.Goal, get_action_names_and_types(node))
        self._client: ActionClient = _Client(node, self._type, full)
        self._handles: dict[bytes, ClientGoalHandle] = {}
        self._is_closed = False
        self._is_checked = False
        self._warn = warn

    def close(self) -> None:
        """Destroy the action client; further calls do nothing."""
        if not self._is_closed:
            self._is_closed = True
            self._client.destroy()

    def is_ready(self) -> bool:
        """Return whether a server is in the graph, with all its services and topics matched."""
        executor = self._node.executor
        if isinstance(executor, ServingExecutor) and executor.offers(self.name):
            return True
        return bool(self._client.server_is_ready())

    def obstacle(self) -> str:
        """Return why the first goal should not be sent; empty if it can.

        A process that was killed counts as a server until its lease is over.
        """
        if self._is_checked:
            return ""
        why = duplicate_servers(self._node, [self.name])
        if why and self._warn is not None:
            self._warn(why)
            why = None
        why = why or qos_conflict(self._node, self.name) or ""
        self._is_checked = not why and self.is_ready()
        return why

    def send(self, goal: Goal, request: Any) -> None:
        """Send the goal with the UUID of its record."""
        goal_id = _uuid(goal)
        goal.refusal = self._listen(self.name)
        service = self._type.Impl.SendGoalService
        asked = service.Request(goal_id=goal_id, goal=request) if self._exchanges else None

        def on_answer(future: Future) -> None:
            handle = future.result()
            if asked is not None:
                answer = service.Response(accepted=handle.accepted, stamp=handle.stamp)
                self._report("send_goal", goal, asked, answer)
            if handle.accepted:
                self._handles[goal.id] = handle
            else:
                # What is known now; else what arrives before the leaf is ticked.
                goal.refused = goal.refusal()
                # rclpy forgets it only with a result
                self._client._feedback_callbacks.pop(goal.id, None)  # noqa: SLF001
            goal.on(GoalTrigger.ACCEPTED if handle.accepted else GoalTrigger.REJECTED)

        future = self._client.send_goal_async(
            request,
            feedback_callback=lambda wrapped: goal.on_feedback(wrapped.feedback),
            goal_uuid=goal_id,
        )
        if asked is not None:
            self._report("send_goal", goal, asked)
        future.add_done_callback(on_answer)

    def recover_goal(self, goal: Goal) -> None:
        """Prepare requests about a goal whose acceptance was not received here."""
        self._handles[goal.id] = self._handle(goal)

    def _handle(self, goal: Goal) -> ClientGoalHandle:
        answer = self._type.Impl.SendGoalService.Response(accepted=True)
        return ClientGoalHandle(self._client, _uuid(goal), answer)

    def move_to(self, node: Node) -> None:
        """Continue on another node; see :meth:`ask_again`."""
        self.close()
        self._client = _Client(node, self._type, self.name)
        self._is_closed = False
        self._handles.clear()

    def ask_again(self, goal: Goal) -> None:
        """Cancel a goal, and ask for its result, if earlier responses cannot arrive any more."""
        if goal.accepted:
            self.recover_goal(goal)
            self.ask_result(goal)
        self.send_cancel(goal)

    def ask_result(self, goal: Goal) -> None:
        """Ask for the result; it arrives when the server has ended the goal."""
        service = self._type.Impl.GetResultService
        asked = service.Request(goal_id=_uuid(goal)) if self._exchanges else None

        def on_result(future: Future) -> None:
            response = future.result()
            if asked is not None:
                self._report("get_result", goal, asked, response)
            self._handles.pop(goal.id, None)
            executor = self._node.executor
            if isinstance(executor, VirtualTimeExecutor):
                goal.raised = executor.take_raised(goal.id)
            goal.on_result(response.status, response.result)

        future = self._handles[goal.id].get_result_async()
        if asked is not None:
            self._report("get_result", goal, asked)
        future.add_done_callback(on_result)

    def send_cancel(self, goal: Goal) -> None:
        """Ask the server to cancel.

        :meth:`_hear_of_cancel` handles the response.
        """
        handle = self._handles.get(goal.id)
        if handle is None:
            if goal.accepted:
                return  # the result is here already
            handle = self._handle(goal)
        asked = CancelGoal.Request()
        asked.goal_info.goal_id = _uuid(goal)

        def on_answer(future: Future) -> None:
            self._report("cancel_goal", goal, asked, future.result())
            self._hear_of_cancel(goal, future.result())

        future = handle.cancel_goal_async()
        self._report("cancel_goal", goal, asked)
        future.add_done_callback(on_answer)

    def _hear_of_cancel(self, goal: Goal, answer: Any) -> None:
        """Take in the answer to a cancel.

        Without the goal it is a refusal, unless the goal has ended: then its result decides, and is
        asked for again, since the first may be lost. A server that does not know a goal that was
        accepted has been started anew. One that cancels a goal, or has ended it, has accepted it,
        even if that has not come here.
        """
        if goal.phase is Phase.ENDED:
            return
        is_taken = goal.id in {bytes(info.goal_id.uuid) for info in answer.goals_canceling}
        is_over = answer.return_code == CancelGoal.Response.ERROR_GOAL_TERMINATED
        if not goal.accepted:
            if is_taken or is_over:
                self.recover_goal(goal)
                goal.on(GoalTrigger.ACCEPTED)
        elif is_over:
            goal.lacks_result = True
            self.ask_result(goal)
        elif answer.return_code == CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID:
            self._handles.pop(goal.id, None)
            goal.on_result(GoalStatus.UNKNOWN, None)
        elif not is_taken:
            goal.on(GoalTrigger.CANCEL_REFUSED)

    def _report(self, service: str, goal: Goal, request: Any, answer: Any = None) -> None:
        if self._exchanges:
            self._exchanges.emit(
                Exchange(self.name, self.type_name, service, goal.id, request, answer)
            )


def _uuid(goal: Goal) -> UUID:
    return UUID(uuid=np.frombuffer(goal.id, np.uint8))  # of a list, each number would be checked
