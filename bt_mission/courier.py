"""The thin layer between a goal and rclpy's action client."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient, get_action_names_and_types
from rclpy.action.client import ClientGoalHandle
from unique_identifier_msgs.msg import UUID

from bt_mission.common.errors import BtMissionError
from bt_mission.common.faults import listed
from bt_mission.goals.goal import Event, Goal
from bt_mission.ros_types import action_type, fill

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rclpy.node import Node
    from rclpy.task import Future


class ActionCourier:
    """Carries goals of one action to its server and brings back what it says.

    :param node: owns the action client.
    :param name: the action's name; resolved against the node's namespace.
    :param type_name: such as ``bt_mission_interfaces/action/Turn``.
    :param why_rejected: asked with the resolved name; empty where nobody knows.
    :raises BtMissionError: when the type is not installed, or the action has another one.
    """

    def __init__(
        self, node: Node, name: str, type_name: str, why_rejected: Callable[[str], str]
    ) -> None:
        self._why_rejected = why_rejected
        self._type = action_type(type_name)
        self.type_name = type_name
        self.name = node.resolve_topic_name(name)
        types = dict(get_action_names_and_types(node)).get(self.name, [])
        if types and type_name not in types:
            raise BtMissionError(f"{self.name} is a {listed(types)}, not a {type_name}")
        self._client = ActionClient(node, self._type, name)
        self._handles: dict[bytes, ClientGoalHandle] = {}

    def is_ready(self) -> bool:
        """Is a server in the graph, with all its services and topics matched?"""
        return bool(self._client.server_is_ready())

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """A goal message with these fields.

        :raises BtMissionError: when a value does not fit its field.
        """
        return fill(self._type.Goal(), fields)

    def send(self, goal: Goal, request: Any) -> None:
        """Send the goal with the UUID of its record."""

        def on_answer(future: Future) -> None:
            handle = future.result()
            if handle.accepted:
                self._handles[goal.id] = handle
            else:
                goal.refusal = self._why_rejected(self.name)
                # rclpy forgets it only with a result
                self._client._feedback_callbacks.pop(goal.id, None)  # noqa: SLF001
            goal.on(Event.ACCEPTED if handle.accepted else Event.REJECTED)

        self._client.send_goal_async(
            request,
            feedback_callback=lambda wrapped: goal.on_feedback(wrapped.feedback),
            goal_uuid=UUID(uuid=list(goal.id)),
        ).add_done_callback(on_answer)

    def find_again(self, goal: Goal) -> None:
        """Be able to speak of a goal that another process has sent."""
        answer = self._type.Impl.SendGoalService.Response(accepted=True)
        self._handles[goal.id] = ClientGoalHandle(self._client, UUID(uuid=list(goal.id)), answer)

    def ask_result(self, goal: Goal) -> None:
        """Ask for the result; it arrives when the server has ended the goal."""

        def on_result(future: Future) -> None:
            response = future.result()
            self._handles.pop(goal.id, None)
            goal.on_result(response.status, response.result)

        self._handles[goal.id].get_result_async().add_done_callback(on_result)

    def send_cancel(self, goal: Goal) -> None:
        """Ask the server to cancel.

        An answer without the goal is a refusal, unless the goal has ended: then its result is on
        the way, and decides.
        """
        handle = self._handles.get(goal.id)
        if handle is None:
            return  # the result is here already

        def on_answer(future: Future) -> None:
            answer = future.result()
            if answer.return_code == CancelGoal.Response.ERROR_GOAL_TERMINATED:
                return
            if goal.id not in {bytes(info.goal_id.uuid) for info in answer.goals_canceling}:
                goal.on(Event.CANCEL_REFUSED)

        handle.cancel_goal_async().add_done_callback(on_answer)
