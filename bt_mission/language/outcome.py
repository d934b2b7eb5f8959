"""The closed list of ways in which an attempt at a goal ends."""

from __future__ import annotations

from enum import StrEnum


class Outcome(StrEnum):
    """How an attempt ended, as the leaf that made it sees it."""

    SUCCEEDED = "succeeded"
    SUCCEEDED_LATE = "succeeded late"
    """After the leaf had requested its cancel."""
    ABORTED = "aborted"
    REJECTED = "rejected"
    CANCELED_BY_CONDITION = "canceled by condition"
    CANCELED_BY_TIMEOUT = "canceled by timeout"
    CANCELED_BY_HALT = "canceled by halt"
    CANCELED_FROM_OUTSIDE = "canceled by another client"
    NO_SERVER = "server not available"
    NO_ANSWER = "no answer to the goal"
    SILENT = "feedback silent for too long"
    SERVER_LOST = "server lost"
    CANCEL_REFUSED = "cancel refused"
    UNCONFIRMED = "unconfirmed"


CANCELED = "canceled"
"""Stands for every outcome of a goal that was canceled."""


def is_outcome(outcome: str, wanted: str) -> bool:
    """Return whether an outcome is the wanted one; `CANCELED` is each of a canceled goal."""
    return outcome == wanted or (wanted == CANCELED and outcome.startswith(CANCELED))
