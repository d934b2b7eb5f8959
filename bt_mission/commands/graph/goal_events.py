"""The events of an action's goals, as data for every view of the commands."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any


class GoalOutcome(StrEnum):
    """The closed list of ways in which a goal sent from the terminal ends."""

    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    CANCELED = "canceled"
    REJECTED = "rejected"
    NOT_SENT = "not sent"
    NO_SERVER = "no server"
    NO_ANSWER = "no answer"
    LOST = "lost"
    """Its server has gone, or does not know it any more."""
    UNCONFIRMED = "unconfirmed"
    """The cancel was not confirmed in time."""
    LEFT = "left"
    """Left at once, by a second Ctrl-C."""


@dataclass(frozen=True)
class GoalResult:
    """The end of a goal, the reason in one line, and the result if the server sent one."""

    how: GoalOutcome
    reason: str
    result: Any = None


@dataclass(frozen=True)
class ServerAwaited:
    """The action has no server yet."""

    action: str

    def __str__(self) -> str:
        return f"waiting for a server of {self.action}"


@dataclass(frozen=True)
class GoalAccepted:
    """The server accepted our goal, whose id is given in hexadecimal digits."""

    goal: str

    def __str__(self) -> str:
        return f"goal {self.goal[:8]} accepted"


@dataclass(frozen=True)
class CancelRequested:
    """The server was asked to cancel our goal."""

    why: str

    def __str__(self) -> str:
        return f"canceling: {self.why}"


@dataclass(frozen=True)
class CancelRefused:
    """The server refused to cancel our goal."""

    def __str__(self) -> str:
        return "the server refused to cancel; asking again each second"


@dataclass(frozen=True)
class GoalEnded:
    """Our goal has ended, `since_s` seconds after its acceptance."""

    end: GoalResult
    since_s: float


@dataclass(frozen=True)
class FeedbackReceived:
    """Feedback arrived, `since_s` seconds after our goal was accepted or another was first seen.

    `goal` is the id of another sender's goal; empty for our own.
    """

    message: Any
    since_s: float
    goal: str = ""


@dataclass(frozen=True)
class GoalStateChanged:
    """Another sender's goal has a new state, `since_s` seconds after it was seen."""

    goal: str
    since_s: float
    state: str
    is_end: bool


GoalEvent = (
    ServerAwaited
    | GoalAccepted
    | CancelRequested
    | CancelRefused
    | GoalEnded
    | FeedbackReceived
    | GoalStateChanged
)
