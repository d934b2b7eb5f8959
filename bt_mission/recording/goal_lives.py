"""The lives of goals, put together from service events, feedback and the trace."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from bt_mission.core.cdr.decoder import DecodedMessage
from bt_mission.core.cdr.definitions import action_of
from bt_mission.recording.model import RecordedGoal
from bt_mission.recording.reading import Channel

STATUSES = {0: "unknown", 4: "succeeded", 5: "canceled", 6: "aborted"}
"""By the numbers of ``action_msgs/msg/GoalStatus``; others are no ends."""

Decode = Callable[[], DecodedMessage]


class GoalLives:
    """Takes in what concerns goals, in the order of time."""

    def __init__(self) -> None:
        self._goals: dict[str, RecordedGoal] = {}

    @property
    def lives(self) -> tuple[RecordedGoal, ...]:
        """All goals, in the order in which they were first heard of."""
        return tuple(self._goals.values())

    def take(self, channel: Channel, time_ns: int, decode: Decode) -> None:
        """Take in a message of one of the topics of an action."""
        action, _, part = channel.topic.partition("/_action/")
        match part:
            case "feedback":
                message = decode()
                goal = self._goal(message.goal_id, action)
                goal.feedback.append((time_ns, message.feedback))
            case "send_goal/_service_event":
                self._take_send(action, channel.type_name, time_ns, decode())
            case "get_result/_service_event":
                self._take_result(action, time_ns, decode())
            case "cancel_goal/_service_event":
                self._take_cancel(action, time_ns, decode())

    def take_event(self, event: Mapping[str, Any], time_ns: int) -> None:
        """Take in what the executive says of one of its goals."""
        goal = self._of(event["goal"], event["action"])
        goal.owner = event["owner"]
        match event["event"].removeprefix("goal "):
            case "sent" | "found again":
                goal.sent_ns = time_ns if goal.sent_ns is None else goal.sent_ns
            case "released" | "handed over":  # as version 1 of the trace has it
                goal.handed_over_ns = time_ns
            case "abandoned" | "given up":
                goal.given_up_ns = time_ns
            case "ended" if event.get("status") is None and goal.rejected_ns is None:
                goal.rejected_ns, goal.status = time_ns, "rejected"

    def _take_send(
        self, action: str, type_name: str, time_ns: int, message: DecodedMessage
    ) -> None:
        for request in message.request:
            goal = self._goal(request.goal_id, action)
            goal.type_name = action_of(type_name)
            goal.values = request.goal
            if goal.sent_ns is None:
                goal.sent_ns = time_ns
            for answer in message.response:
                if answer.accepted:
                    goal.accepted_ns = time_ns
                else:
                    goal.rejected_ns, goal.status = time_ns, "rejected"

    def _take_result(self, action: str, time_ns: int, message: DecodedMessage) -> None:
        for request in message.request:
            for answer in message.response:
                goal = self._goal(request.goal_id, action)
                goal.ended_ns = time_ns
                goal.status = STATUSES.get(answer.status, "unknown")
                goal.result = answer.result

    def _take_cancel(self, action: str, time_ns: int, message: DecodedMessage) -> None:
        if message.response:
            return
        for request in message.request:
            goal = self._goal(request.goal_info.goal_id, action)
            goal.cancel_ns = time_ns if goal.cancel_ns is None else goal.cancel_ns

    def _goal(self, goal_id: DecodedMessage, action: str) -> RecordedGoal:
        return self._of(bytes(goal_id.uuid).hex(), action)

    def _of(self, goal_id: str, action: str) -> RecordedGoal:
        return self._goals.setdefault(goal_id, RecordedGoal(goal_id, action))
