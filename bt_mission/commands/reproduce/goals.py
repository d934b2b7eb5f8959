"""The goals in a recording: what was asked, what was answered, and when."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_mission.cdr.decoder import DecodedMessage
from bt_mission.cdr.definitions import action_of
from bt_mission.recording.happenings import GoalMessage
from bt_mission.recording.reader import STATUSES

ENDED = frozenset(STATUSES.values()) - {"unknown"}
SUCCEEDED = "succeeded"
MOST_GOALS = 10_000


@dataclass
class Cancel:
    """A request to cancel a goal, and the answer: its return code, 0 where it was accepted."""

    asked_ns: int
    answered_ns: int | None = None
    code: int | None = None


@dataclass
class GoalTrace:
    """A goal, with the times of its messages, ns; None for what is not in the recording."""

    id: str
    action: str
    type_name: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)
    sent_ns: int | None = None
    answered_ns: int | None = None
    is_rejected: bool = False
    cancels: list[Cancel] = field(default_factory=list)
    ended_ns: int | None = None
    """When the result arrived."""
    status: str = ""
    """``succeeded``, ``canceled`` or ``aborted`` by its result; empty without one."""
    result: Mapping[str, Any] | None = None
    first_known_ns: int | None = None
    """When the status topic first named it."""
    served_end_ns: int | None = None
    """When the status topic said that it has ended."""
    served_status: str = ""
    feedback: int = 0
    first_feedback_ns: int | None = None
    last_feedback_ns: int | None = None
    longest_silence_ns: tuple[int, int] | None = None
    """The longest time without feedback between two messages: start and end."""
    last_feedback: Mapping[str, Any] = field(default_factory=dict)

    @property
    def start_ns(self) -> int:
        """When it was sent, or first seen."""
        known = (self.sent_ns, self.answered_ns, self.first_known_ns, self.first_feedback_ns)
        return next(time_ns for time_ns in known if time_ns is not None)

    @property
    def is_answered(self) -> bool:
        """Whether the goal response is in the recording."""
        return self.answered_ns is not None

    @property
    def is_introspected(self) -> bool:
        """Whether the recording has the requests of the goal, not only its hidden topics."""
        return self.sent_ns is not None

    @property
    def outcome(self) -> str:
        """The end for its client as a word; ``lost`` for a goal whose result it did not get."""
        if self.is_rejected:
            return "rejected"
        if self.is_introspected:
            return self.status if self.is_answered and self.status else "lost"
        return self.status or self.served_status or "lost"

    @property
    def end_ns(self) -> int | None:
        """When it ended, for its client or by the status topic."""
        if self.is_rejected:
            return self.answered_ns
        return self.ended_ns or self.served_end_ns


class GoalTraces:
    """Takes the messages of actions, in the order of time."""

    def __init__(self) -> None:
        self._goals: dict[str, GoalTrace] = {}
        self._types: dict[str, str] = {}

    @property
    def goals(self) -> list[GoalTrace]:
        """All, in the order of their start."""
        known = [goal for goal in self._goals.values() if goal.feedback or _is_timed(goal)]
        return sorted(known, key=lambda goal: goal.start_ns)

    def take(self, time_ns: int, happening: GoalMessage) -> None:
        """Take a message between a client and a server."""
        match happening.part:
            case "feedback":
                self._types.setdefault(happening.action, _by_feedback(happening))
                self._take_feedback(time_ns, happening)
            case "status":
                for entry in happening.message.status_list:
                    self._take_status(time_ns, happening.action, entry)
            case "send_goal/_service_event":
                self._take_send(time_ns, happening)
            case "get_result/_service_event":
                self._take_result(time_ns, happening)
            case "cancel_goal/_service_event":
                self._take_cancel(time_ns, happening)

    def type_of(self, action: str) -> str:
        """Return the type of an action; empty if it is unknown."""
        return self._types.get(action, "")

    def _take_feedback(self, time_ns: int, happening: GoalMessage) -> None:
        goal = self._goal(happening.message.goal_id, happening.action)
        if goal is None:
            return
        before = goal.last_feedback_ns
        if before is None:
            goal.first_feedback_ns = time_ns
        else:
            longest = goal.longest_silence_ns
            if longest is None or time_ns - before > longest[1] - longest[0]:
                goal.longest_silence_ns = before, time_ns
        goal.feedback += 1
        goal.last_feedback_ns = time_ns
        goal.last_feedback = happening.message.feedback

    def _take_status(self, time_ns: int, action: str, entry: DecodedMessage) -> None:
        goal = self._goal(entry.goal_info.goal_id, action)
        if goal is None:
            return
        if goal.first_known_ns is None:
            goal.first_known_ns = time_ns
        word = STATUSES.get(entry.status, "")
        if word in ENDED and not goal.served_status:
            goal.served_status, goal.served_end_ns = word, time_ns

    def _take_send(self, time_ns: int, happening: GoalMessage) -> None:
        for request in happening.message.request:
            goal = self._goal(request.goal_id, happening.action)
            if goal is None:
                continue
            goal.type_name = action_of(happening.channel.type_name)
            self._types[goal.action] = goal.type_name
            goal.values = request.goal
            if goal.sent_ns is None:
                goal.sent_ns = time_ns
            for answer in happening.message.response:
                goal.answered_ns = time_ns
                goal.is_rejected = not answer.accepted

    def _take_result(self, time_ns: int, happening: GoalMessage) -> None:
        for request in happening.message.request:
            goal = self._goal(request.goal_id, happening.action)
            for answer in happening.message.response if goal is not None else ():
                assert goal is not None
                goal.ended_ns = time_ns
                goal.status = STATUSES.get(answer.status, "unknown")
                goal.result = answer.result

    def _take_cancel(self, time_ns: int, happening: GoalMessage) -> None:
        for request in happening.message.request:
            goal = self._goal(request.goal_info.goal_id, happening.action)
            if goal is None:
                continue
            if not happening.message.response:
                goal.cancels.append(Cancel(time_ns))
                continue
            open_ones = [cancel for cancel in goal.cancels if cancel.answered_ns is None]
            cancel = open_ones[0] if open_ones else Cancel(time_ns)
            if not open_ones:
                goal.cancels.append(cancel)
            cancel.answered_ns = time_ns
            cancel.code = int(happening.message.response[0].return_code)

    def _goal(self, goal_id: DecodedMessage, action: str) -> GoalTrace | None:
        key = bytes(goal_id.uuid).hex()
        if key not in self._goals and len(self._goals) >= MOST_GOALS:
            return None
        return self._goals.setdefault(key, GoalTrace(key, action))


def _by_feedback(happening: GoalMessage) -> str:
    """Return the action of a feedback topic, by the name of its type."""
    name = happening.channel.type_name.replace("/msg/", "/action/")
    return re.sub("_?FeedbackMessage$", "", name)


def _is_timed(goal: GoalTrace) -> bool:
    return any(time is not None for time in (goal.sent_ns, goal.first_known_ns, goal.answered_ns))
