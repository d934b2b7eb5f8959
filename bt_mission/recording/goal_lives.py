"""The goals in a recording: requests, responses and results, and what the executive reports."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bt_mission.cdr.decoder import DecodedMessage, DecodingError
from bt_mission.cdr.definitions import action_of
from bt_mission.executive.events.events import GoalChanged
from bt_mission.executive.events.goal_life import GoalLife
from bt_mission.recording.recorded_messages import GoalMessage

ENDS = {4: "succeeded", 5: "canceled", 6: "aborted"}
"""The final statuses, by the numbers of ``action_msgs/msg/GoalStatus``."""

GOAL_ID_BYTES = 16

MOST_GOALS = 100_000
"""Of a recording; messages of further ones are not read."""


@dataclass
class Cancel:
    """A request to cancel a goal, and the answer: its return code, 0 where it was accepted."""

    asked_ns: int
    answered_ns: int | None = None
    code: int | None = None


@dataclass(eq=False)
class RecordedGoal(GoalLife):
    """The life of a goal with its messages. Times are None for what is not in the recording.

    Attributes:
        values: The fields of the goal.
        requested_ns: When its request was sent.
        answered_ns: When its response arrived.
        result_ns: When its result arrived.
        result_status: ``succeeded``, ``canceled``, ``aborted`` or ``unknown``; empty without a
            result.
        result: The fields of the result.
        first_known_ns: When the status topic first named it.
        served_end_ns: When the status topic said that it has ended.
        served_status: How, by the status topic.
        feedback: The fields of each feedback, with its time.
    """

    type_name: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)
    requested_ns: int | None = None
    answered_ns: int | None = None
    was_refused: bool = False
    cancels: list[Cancel] = field(default_factory=list)
    result_ns: int | None = None
    result_status: str = ""
    result: Mapping[str, Any] | None = None
    first_known_ns: int | None = None
    served_end_ns: int | None = None
    served_status: str = ""
    feedback: list[tuple[int, Mapping[str, Any]]] = field(default_factory=list)

    @property
    def sent_ns(self) -> int | None:
        """When it was sent."""
        return _first(self.requested_ns, self.change_ns("sent", "found again"))

    @property
    def start_ns(self) -> int:
        """When it was sent, or first seen; 0 for one with a cancel or a result only."""
        seen_ns = self.feedback[0][0] if self.feedback else None
        return _first(self.sent_ns, self.first_known_ns, seen_ns) or 0

    @property
    def accepted_ns(self) -> int | None:
        """When it was accepted."""
        return None if self.was_refused else self.answered_ns

    @property
    def rejected_ns(self) -> int | None:
        """When it was rejected."""
        if self.was_refused:
            return self.answered_ns
        ends = (time_ns for time_ns, event in self.changes if event.state == "rejected")
        return next(ends, None)

    @property
    def released_ns(self) -> int | None:
        """When its leaf released it."""
        return self.change_ns("released")

    @property
    def abandoned_ns(self) -> int | None:
        """When the ledger stopped waiting for its server."""
        return self.change_ns("abandoned")

    @property
    def end_ns(self) -> int | None:
        """When it ended, was rejected, or was abandoned; else when its server ended it."""
        return _first(self.result_ns, self.rejected_ns, self.abandoned_ns, self.served_end_ns)

    @property
    def status(self) -> str:
        """The status of its result, or ``rejected``; empty without both."""
        return self.result_status or ("" if self.rejected_ns is None else "rejected")

    @property
    def outcome(self) -> str:
        """The end for its client as a word; ``lost`` for a goal whose result it did not get."""
        if self.requested_ns is not None and self.answered_ns is None:
            return "lost"
        served = self.served_status if self.requested_ns is None else ""
        return self.status or served or "lost"


class GoalLives:
    """Takes what concerns goals, in the order of time."""

    def __init__(self) -> None:
        self._goals: dict[str, RecordedGoal] = {}
        self._types: dict[str, str] = {}

    @property
    def lives(self) -> tuple[RecordedGoal, ...]:
        """All goals, in the order of their first message."""
        for goal in self._goals.values():
            goal.type_name = goal.type_name or self._types.get(goal.action, "")
        return tuple(self._goals.values())

    def take_change(self, time_ns: int, event: GoalChanged) -> None:
        """Take a change that the executive reports."""
        self._of(event.id, event.action).take(event, time_ns)

    def take(self, time_ns: int, happening: GoalMessage) -> None:
        """Take a message between an action's client and its server.

        Raises:
            DecodingError: For a message of another form.
        """
        action = happening.action
        match happening.part:
            case "feedback":
                message = happening.message
                self._types.setdefault(action, _type_by_feedback(happening))
                goal = self._goal(message.goal_id, action)
                goal.feedback.append((time_ns, _fields(message.feedback)))
            case "status":
                for entry in happening.message.status_list:
                    self._take_status(time_ns, self._goal(entry.goal_info.goal_id, action), entry)
            case "send_goal/_service_event":
                self._take_send(time_ns, happening)
            case "get_result/_service_event":
                self._take_result(action, time_ns, happening.message)
            case "cancel_goal/_service_event":
                self._take_cancel(action, time_ns, happening.message)

    @staticmethod
    def _take_status(time_ns: int, goal: RecordedGoal, entry: DecodedMessage) -> None:
        goal.first_known_ns = _first(goal.first_known_ns, time_ns)
        if entry.status in ENDS and not goal.served_status:
            goal.served_status, goal.served_end_ns = ENDS[entry.status], time_ns

    def _take_send(self, time_ns: int, happening: GoalMessage) -> None:
        for request in happening.message.request:
            goal = self._goal(request.goal_id, happening.action)
            goal.type_name = self._types[goal.action] = action_of(happening.channel.type_name)
            goal.values = _fields(request.goal)
            goal.requested_ns = _first(goal.requested_ns, time_ns)
            for answer in happening.message.response:
                goal.answered_ns, goal.was_refused = time_ns, not answer.accepted

    def _take_result(self, action: str, time_ns: int, message: DecodedMessage) -> None:
        for request in message.request:
            for answer in message.response:
                goal = self._goal(request.goal_id, action)
                goal.result_ns = time_ns
                goal.result_status = ENDS.get(answer.status, "unknown")
                goal.result = _fields(answer.result)

    def _take_cancel(self, action: str, time_ns: int, message: DecodedMessage) -> None:
        for request in message.request:
            goal = self._goal(request.goal_info.goal_id, action)
            if not message.response:
                goal.cancels.append(Cancel(time_ns))
                continue
            open_ones = [cancel for cancel in goal.cancels if cancel.answered_ns is None]
            cancel = open_ones[0] if open_ones else Cancel(time_ns)
            if not open_ones:
                goal.cancels.append(cancel)
            cancel.answered_ns, cancel.code = time_ns, int(message.response[0].return_code)

    def _goal(self, goal_id: DecodedMessage, action: str) -> RecordedGoal:
        if np.shape(goal_id.uuid) != (GOAL_ID_BYTES,):
            raise DecodingError(f"a goal's id is expected to have {GOAL_ID_BYTES} bytes")
        return self._of(bytes(goal_id.uuid).hex(), action)

    def _of(self, goal_id: str, action: str) -> RecordedGoal:
        if goal_id not in self._goals and len(self._goals) >= MOST_GOALS:
            raise DecodingError(f"more than {MOST_GOALS:,} goals")
        return self._goals.setdefault(goal_id, RecordedGoal(goal_id, action))


def _first(*times_ns: int | None) -> int | None:
    return next((time_ns for time_ns in times_ns if time_ns is not None), None)


def _fields(message: Any) -> DecodedMessage:
    """Return the fields of a goal, a result or a feedback, without its envelope."""
    if not isinstance(message, DecodedMessage):
        raise DecodingError(f"expected a message, got {type(message).__name__}")
    return message


def _type_by_feedback(happening: GoalMessage) -> str:
    """Return the action of a feedback topic, by the name of its type."""
    name = happening.channel.type_name.replace("/msg/", "/action/")
    return re.sub("_?FeedbackMessage$", "", name)
