"""One goal as its server sees it: a state machine whose table is written once.

The machine knows nothing of leaves, limits or ROS. It is told what happened (:class:`Event`) and
answers with what to do (:class:`Command`). A pair that is not in the table changes nothing: late
and stale messages are noted by the ledger and otherwise without effect.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from types import MappingProxyType
from typing import Any, Protocol

from bt_mission.goals.poses import NamedPose

UNREAD_FEEDBACK = 1_000
"""Feedback kept between two ticks; beyond it the oldest is dropped."""


class Phase(StrEnum):
    """Where a goal stands between its request and its confirmed end."""

    SENT = "sent"
    RECALLED = "recalled"
    """No longer wanted before the server answered, which may have accepted it all the same: it is
    asked to cancel, and once more as soon as it accepts."""
    ACTIVE = "active"
    CANCELING = "canceling"
    LOST = "lost"
    """Given up: nothing confirms that it ended. Whatever is still heard of it is acted upon."""
    ENDED = "ended"


class Event(StrEnum):
    """What can happen to a goal."""

    ACCEPTED = "accepted"
    REJECTED = "rejected"
    UNWANTED = "unwanted"
    CANCEL_REFUSED = "cancel refused"
    RESULT = "result"
    GIVEN_UP = "abandoned"


class Command(StrEnum):
    """What to do about an event."""

    ASK_RESULT = "ask for the result"
    SEND_CANCEL = "send a cancel request"


class GoalStatus(IntEnum):
    """Final states, with the numbers of ``action_msgs/msg/GoalStatus``."""

    UNKNOWN = 0
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6


TRANSITIONS: Mapping[tuple[Phase, Event], tuple[Phase, tuple[Command, ...]]] = MappingProxyType(
    {
        (Phase.SENT, Event.ACCEPTED): (Phase.ACTIVE, (Command.ASK_RESULT,)),
        (Phase.SENT, Event.REJECTED): (Phase.ENDED, ()),
        (Phase.SENT, Event.UNWANTED): (Phase.RECALLED, (Command.SEND_CANCEL,)),
        (Phase.SENT, Event.GIVEN_UP): (Phase.LOST, ()),
        (Phase.RECALLED, Event.ACCEPTED): (
            Phase.CANCELING,
            (Command.ASK_RESULT, Command.SEND_CANCEL),
        ),
        (Phase.RECALLED, Event.REJECTED): (Phase.ENDED, ()),
        (Phase.RECALLED, Event.UNWANTED): (Phase.RECALLED, (Command.SEND_CANCEL,)),
        (Phase.RECALLED, Event.GIVEN_UP): (Phase.LOST, ()),
        (Phase.ACTIVE, Event.UNWANTED): (Phase.CANCELING, (Command.SEND_CANCEL,)),
        (Phase.ACTIVE, Event.RESULT): (Phase.ENDED, ()),
        (Phase.ACTIVE, Event.GIVEN_UP): (Phase.LOST, ()),
        (Phase.CANCELING, Event.CANCEL_REFUSED): (Phase.ACTIVE, ()),
        (Phase.CANCELING, Event.UNWANTED): (Phase.CANCELING, (Command.SEND_CANCEL,)),
        (Phase.CANCELING, Event.RESULT): (Phase.ENDED, ()),
        (Phase.CANCELING, Event.GIVEN_UP): (Phase.LOST, ()),
        (Phase.LOST, Event.ACCEPTED): (
            Phase.CANCELING,
            (Command.ASK_RESULT, Command.SEND_CANCEL),
        ),
        (Phase.LOST, Event.REJECTED): (Phase.ENDED, ()),
        (Phase.LOST, Event.RESULT): (Phase.ENDED, ()),
    }
)


class GoalClient(Protocol):
    """Carries a goal's requests to its server, as rclpy's action client does."""

    name: str
    """The resolved name of the action."""
    type_name: str
    """Its type."""

    def is_ready(self) -> bool:
        """Is a server there and matched?"""

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """A goal request with these fields.

        Raises:
            BtMissionError: When they do not fit the action's type.
        """

    def send(self, goal: Goal, request: Any) -> None:
        """Send a prepared request; what comes back goes into ``goal``'s methods."""

    def recover_goal(self, goal: Goal) -> None:
        """Be able to speak of a goal that another process has sent."""

    def ask_result(self, goal: Goal) -> None:
        """Ask for the result of an accepted goal."""

    def send_cancel(self, goal: Goal) -> None:
        """Ask the server to cancel a goal, also one that it has not answered."""


@dataclass(eq=False)
class Goal:
    """The record of one goal, from the request to the confirmed end.

    Args:
        id: The goal's UUID, 16 bytes.
        goal_client: Carries its requests.
        owner: Who sent it, for people.
        grace_ns: How long it may take to end once nobody wants it, until it is left behind.
        request: What was sent, in the client's form.
    """

    id: bytes
    goal_client: GoalClient
    owner: str
    grace_ns: int = 0
    request: Any = None
    phase: Phase = Phase.SENT
    accepted: bool = False
    cancel_refused: bool = False
    status: GoalStatus | None = None
    result: Any = None
    refusal: Callable[[], str] = str
    """Returns why the server has rejected it; empty where nobody knows."""
    refused: str = ""
    """The same, as it was known when the rejection came."""
    raised: str = ""
    """What the server's callback has raised, and where; empty where nobody knows."""
    feedback: Any = None
    unread: deque[Any] = field(default_factory=lambda: deque(maxlen=UNREAD_FEEDBACK))
    orphaned_ns: int | None = None
    sent_ns: int = 0
    targets: tuple[NamedPose, ...] = ()
    """The places that its request names."""
    reported: Phase = Phase.SENT
    """The phase that the ledger has reported last."""

    @property
    def is_live(self) -> bool:
        """May the server still be working on it, as far as is known?"""
        return self.phase not in (Phase.ENDED, Phase.LOST)

    @property
    def short_id(self) -> str:
        """The first eight digits of the UUID, for people."""
        return self.id.hex()[:8]

    def on(self, event: Event) -> None:
        """Take in an event, by the table; do what it commands."""
        known = TRANSITIONS.get((self.phase, event))
        if known is None:
            return
        self.phase, commands = known
        if event is Event.ACCEPTED:
            self.accepted = True
        elif event is Event.CANCEL_REFUSED:
            self.cancel_refused = True
        elif event is Event.UNWANTED:
            self.cancel_refused = False
        for command in commands:
            if command is Command.ASK_RESULT:
                self.goal_client.ask_result(self)
            else:
                self.goal_client.send_cancel(self)

    def on_result(self, status: int, result: Any) -> None:
        """Take in the result; a status that is no final one counts as unknown."""
        if (self.phase, Event.RESULT) in TRANSITIONS:
            known = status in GoalStatus._value2member_map_
            self.status = GoalStatus(status) if known else GoalStatus.UNKNOWN
            self.result = result
        self.on(Event.RESULT)

    def on_feedback(self, feedback: Any) -> None:
        """Take in feedback; it may overtake the acceptance, and after the end it is dropped."""
        if self.phase is not Phase.ENDED:
            self.feedback = feedback
            self.unread.append(feedback)


_ENDS = {
    GoalStatus.SUCCEEDED: "succeeded",
    GoalStatus.CANCELED: "canceled",
    GoalStatus.ABORTED: "aborted",
    GoalStatus.UNKNOWN: "unknown",
}


def state_of(goal: Goal) -> str:
    """Return the state of a goal in one word: its phase, and once it has ended, how."""
    if goal.phase is not Phase.ENDED:
        return str(goal.phase)
    if not goal.accepted:
        return "rejected"
    return _ENDS[GoalStatus.UNKNOWN if goal.status is None else goal.status]
