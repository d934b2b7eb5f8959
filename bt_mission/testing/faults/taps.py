"""What faults make of messages, requests and answers on their way."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

from bt_mission.testing.errors import ScenarioError
from bt_mission.testing.faults.fault import Fates, FaultInstance, Tap
from bt_mission.virtual_time import Delivery, Passing


def passed(_: FaultInstance, passing: Passing) -> Fates:
    """Let it go on as if nothing were wrong."""
    return (Delivery(passing.message),)


def lost(_: FaultInstance, _passing: Passing) -> Fates:
    """Lose it."""
    return ()


def later(what: str, by: float) -> Tap:
    """Make a tap that delivers late, by so many seconds."""
    by_ns = nanoseconds(what, by)
    return lambda _, passing: (Delivery(passing.message, after_ns=by_ns),)


def repeated(what: str, times: int, after: float) -> Tap:
    """Make a tap that delivers so many times, with so many seconds from each to the next."""
    if times < 2:
        raise ScenarioError(f"{what}: expected 2 times or more, got {times!r}")
    after_ns = nanoseconds("after", after)
    return lambda _, passing: [
        Delivery(deepcopy(passing.message), after_ns=number * after_ns) for number in range(times)
    ]


def check_share(what: str, share: float) -> None:
    """Refuse a share that is none.

    Raises:
        ScenarioError: when it is not above 0 and at most 1.
    """
    if not 0 < share <= 1:
        raise ScenarioError(f"{what}: expected a share above 0 and at most 1, got {share!r}")


def for_share(share: float, tap: Tap) -> Tap:
    """Let a tap see a share of what passes, drawn from the mission's seed."""
    if share == 1:
        return tap
    return lambda fault, passing: (
        tap(fault, passing) if fault.draw(passing).random() < share else passed(fault, passing)
    )


def for_first(what: str, count: Any, tap: Tap) -> Tap:
    """Let a tap see so many things that pass, after which its fault ends; None is all."""
    if count is None:
        return tap
    if not isinstance(count, int) or count < 1:
        raise ScenarioError(f"{what}: expected an integer from 1 up, got {count!r}")

    def counted(fault: FaultInstance, passing: Passing) -> Fates:
        if fault.ended_ns is not None:
            return passed(fault, passing)
        fault.ends_at_call(count)
        return tap(fault, passing)

    return counted


def nanoseconds(what: str, seconds: float) -> int:
    """Return seconds in ns.

    Raises:
        ScenarioError: when they are below 0, or no number.
    """
    if not 0 <= seconds < float("inf"):
        raise ScenarioError(f"expected {what} in seconds, 0 or more, got {seconds!r}")
    return round(seconds * 1e9)
