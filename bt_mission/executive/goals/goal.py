"""One goal as its server sees it: a state machine with one transition table.

The machine does not depend on leaves, limits or ROS. Its input is a :class:`GoalTrigger`, its
output a :class:`GoalCommand`. A pair that is not in the table changes nothing: late and stale
messages are noted by the ledger and have no other effect.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from types import MappingProxyType
from typing import Any, Protocol, TypeAlias

from bt_mission.executive.goals.poses import NamedPose

UNREAD_FEEDBACK = 1_000
"""The number of feedback messages kept between two ticks. The oldest is dropped beyond it."""


class Phase(StrEnum):
    """The phase of a goal between its request and its confirmed end."""

    SENT = "sent"
    RECALLED = "recalled"
    """No longer wanted before the server answered. The goal is asked to cancel now, and again when
    it is accepted.
    """
    ACTIVE = "active"
    CANCELING = "canceling"
    LOST = "lost"
    """Given up: nothing confirms that it ended. Later messages about it are still handled."""
    ENDED = "ended"


class GoalTrigger(StrEnum):
    """An event in the life of a goal."""

    ACCEPTED = "accepted"
    REJECTED = "rejected"
    UNWANTED = "unwanted"
    CANCEL_REFUSED = "cancel refused"
    RESULT = "result"
    GIVEN_UP = "abandoned"


class GoalCommand(StrEnum):
    """A command that follows from an event."""

    ASK_RESULT = "ask for the result"
    SEND_CANCEL = "send a cancel request"


class GoalStatus(IntEnum):
    """Final states, with the numbers of ``action_msgs/msg/GoalStatus``."""

    UNKNOWN = 0
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6


Transitions: TypeAlias = Mapping[tuple[Phase, GoalTrigger], tuple[Phase, tuple[GoalCommand, ...]]]

TRANSITIONS: Transitions = MappingProxyType(
    {
        (Phase.SENT, GoalTrigger.ACCEPTED): (Phase.ACTIVE, (GoalCommand.ASK_RESULT,)),
        (Phase.SENT, GoalTrigger.REJECTED): (Phase.ENDED, ()),
        (Phase.SENT, GoalTrigger.UNWANTED): (Phase.RECALLED, (GoalCommand.SEND_CANCEL,)),
        (Phase.SENT, GoalTrigger.GIVEN_UP): (Phase.LOST, ()),
        (Phase.RECALLED, GoalTrigger.ACCEPTED): (
            Phase.CANCELING,
            (GoalCommand.ASK_RESULT, GoalCommand.SEND_CANCEL),
        ),
        (Phase.RECALLED, GoalTrigger.REJECTED): (Phase.ENDED, ()),
        (Phase.RECALLED, GoalTrigger.UNWANTED): (Phase.RECALLED, (GoalCommand.SEND_CANCEL,)),
        (Phase.RECALLED, GoalTrigger.GIVEN_UP): (Phase.LOST, ()),
        (Phase.ACTIVE, GoalTrigger.UNWANTED): (Phase.CANCELING, (GoalCommand.SEND_CANCEL,)),
        (Phase.ACTIVE, GoalTrigger.RESULT): (Phase.ENDED, ()),
        (Phase.ACTIVE, GoalTrigger.GIVEN_UP): (Phase.LOST, ()),
        (Phase.CANCELING, GoalTrigger.CANCEL_REFUSED): (Phase.ACTIVE, ()),
        (Phase.CANCELING, GoalTrigger.UNWANTED): (Phase.CANCELING, (GoalCommand.SEND_CANCEL,)),
        (Phase.CANCELING, GoalTrigger.RESULT): (Phase.ENDED, ()),
        (Phase.CANCELING, GoalTrigger.GIVEN_UP): (Phase.LOST, ()),
        (Phase.LOST, GoalTrigger.ACCEPTED): (
            Phase.CANCELING,
            (GoalCommand.ASK_RESULT, GoalCommand.SEND_CANCEL),
        ),
        (Phase.LOST, GoalTrigger.REJECTED): (Phase.ENDED, ()),
        (Phase.LOST, GoalTrigger.RESULT): (Phase.ENDED, ()),
    }
)


class GoalClient(Protocol):
    """Sends a goal's requests to its server, as rclpy's action client does."""

    name: str
    """The resolved name of the action."""
    type_name: str
    """Its type."""

    def is_ready(self) -> bool:
        """Return whether a server is there and matched."""

    def obstacle(self) -> str:
        """Return why no goal should be sent, whether or not a server is there; empty if it can."""

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """A goal request with these fields.

        Raises:
            BtMissionError: When they do not fit the action's type.
        """

    def send(self, goal: Goal, request: Any) -> None:
        """Send a prepared request. The answers are passed to the methods of ``goal``."""

    def recover_goal(self, goal: Goal) -> None:
        """Prepare requests about a goal that another process has sent."""

    def ask_result(self, goal: Goal) -> None:
        """Ask for the result of an accepted goal."""

    def send_cancel(self, goal: Goal) -> None:
        """Ask the server to cancel a goal, even if the server has not answered the goal yet."""


NO_CALLBACK = " (rclpy refuses unless the server has a cancel_callback that accepts)"
FORGOTTEN = "no longer knows the goal (it has restarted, or its result_timeout is 0)"
"""What a server says of a goal that it has accepted: STATUS_UNKNOWN."""


@dataclass(eq=False)
class Goal:
    """A goal from its request to its confirmed end.

    Args:
        id: The goal's UUID, 16 bytes.
        goal_client: Sends its requests.
        owner: The name of its sender, for messages.
        grace_ns: The time that it may take to end once it is not wanted, ns; after that it is
            orphaned.
        request: The request, in the client's form.
        uses: The parts of the robot that it moves.
    """

    id: bytes
    goal_client: GoalClient
    owner: str
    grace_ns: int = 0
    request: Any = None
    phase: Phase = Phase.SENT
    accepted: bool = False
    cancel_refused: bool = False
    lacks_result: bool = False
    """Its server has answered a cancel: the goal has ended. Its result is not here."""
    status: GoalStatus | None = None
    result: Any = None
    refusal: Callable[[], str] = str
    """Returns why the server has rejected the goal; empty if that is not known."""
    refused: str = ""
    """The reason of the rejection, as known when the rejection arrived."""
    raised: str = ""
    """The exception of the server's callback and its place; empty if that is not known."""
    feedback: Any = None
    unread: deque[Any] = field(default_factory=lambda: deque(maxlen=UNREAD_FEEDBACK))
    orphaned_ns: int | None = None
    sent_ns: int = 0
    uses: frozenset[str] = frozenset()
    targets: tuple[NamedPose, ...] = ()
    """The places that its request names."""
    reported: Phase = Phase.SENT
    """The phase that the ledger has reported last."""

    @property
    def is_live(self) -> bool:
        """Whether the server may still be working on the goal, as far as is known."""
        return self.phase not in (Phase.ENDED, Phase.LOST)

    @property
    def is_ending(self) -> bool:
        """Whether it is not wanted any more, and its server has not confirmed its end."""
        is_unwanted = self.orphaned_ns is not None or self.phase in (
            Phase.RECALLED,
            Phase.CANCELING,
        )
        return self.is_live and is_unwanted

    @property
    def short_id(self) -> str:
        """The first eight digits of the UUID, for people."""
        return self.id.hex()[:8]

    def on(self, event: GoalTrigger) -> None:
        """Handle an event by the table, and run the command."""
        known = TRANSITIONS.get((self.phase, event))
        if known is None:
            return
        self.phase, commands = known
        if event is GoalTrigger.ACCEPTED:
            self.accepted = True
        elif event is GoalTrigger.CANCEL_REFUSED:
            self.cancel_refused = True
        elif event is GoalTrigger.UNWANTED:
            self.cancel_refused = False
        for command in commands:
            if command is GoalCommand.ASK_RESULT:
                self.goal_client.ask_result(self)
            else:
                self.goal_client.send_cancel(self)

    def on_result(self, status: int, result: Any) -> None:
        """Handle the result. A status that is not final counts as unknown."""
        if (self.phase, GoalTrigger.RESULT) in TRANSITIONS:
            known = status in GoalStatus._value2member_map_
            self.status = GoalStatus(status) if known else GoalStatus.UNKNOWN
            self.result = result
        self.on(GoalTrigger.RESULT)

    def on_feedback(self, feedback: Any) -> None:
        """Handle feedback. It may overtake the acceptance; after the end it is dropped."""
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
    """Return the state of a goal as one word: its phase or, after its end, its status."""
    if goal.phase is not Phase.ENDED:
        return str(goal.phase)
    if not goal.accepted:
        return "rejected"
    return _ENDS[GoalStatus.UNKNOWN if goal.status is None else goal.status]
