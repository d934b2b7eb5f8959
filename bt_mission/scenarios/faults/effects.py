"""What becomes of things that pass: lost, late, repeated, for some of them, on a channel."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from copy import deepcopy
from typing import TypeAlias

from bt_mission.base.errors import BtMissionError
from bt_mission.ros.virtual_time import ACTION_PARTS, Delivery, Passing, Side
from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.scenarios.faults.fault import Fates, FaultInstance, Tap
from bt_mission.scenarios.faults.kind import Arguments, Effect

Channel: TypeAlias = Callable[[FaultInstance, Arguments], Iterable[tuple[str, Side]]]
"""Names the topics and services that a fault affects, each with what of it passes."""

MakeTap: TypeAlias = Callable[[FaultInstance, Arguments], Tap]
"""Makes what decides, of the arguments of a fault."""

PARTS = ("goal", "cancel", "result")
"""The services of an action."""


# ---- channels ----------------------------------------------------------------------------------


def topic(fault: FaultInstance, given: Arguments) -> Iterable[tuple[str, Side]]:
    """The messages of a topic."""
    return [(fault.topic(given["topic"]), Side.MESSAGE)]


def action(*sides: tuple[str, Side]) -> Channel:
    """Return the channel of parts of an action, each on a side."""
    return lambda fault, given: [
        (f"{fault.action(given['action'])}/_action/{ACTION_PARTS[part]}", side)
        for part, side in sides
    ]


def service(side: Side) -> Channel:
    """Return the channel of the requests to a service, or of its responses."""
    return lambda fault, given: [(fault.service(given["service"])[0], side)]


FEEDBACK = action(("feedback", Side.MESSAGE))


def on(channel: Channel, make: MakeTap, first: str = "goals") -> Effect:
    """Return the effect that decides what becomes of what passes on a channel.

    It affects a ``share`` of it, what one ``receiver`` gets, or the first ``count``, where the
    fault takes these arguments.

    Args:
        first: Name of the argument that says how many.
    """

    def effect(fault: FaultInstance, given: Arguments) -> None:
        tap = _for_share(given.get("share", 1.0), make(fault, given))
        tap = _for_first(given.get(first), tap)
        named = list(channel(fault, given))
        receiver = receiver_of(fault, given)
        for name, side in named:
            fault.tap(name, side, tap, receiver)

    return effect


def receiver_of(fault: FaultInstance, given: Arguments) -> str | None:
    """Return the full name of the one node that is affected; None is all."""
    name = given.get("receiver")
    return None if name is None else fault.node(name).get_fully_qualified_name()


def _for_share(share: float, tap: Tap) -> Tap:
    if share == 1:
        return tap
    return lambda fault, passing: (
        tap(fault, passing) if fault.draw(passing).random() < share else passed(fault, passing)
    )


def _for_first(count: int | None, tap: Tap) -> Tap:
    """Let a tap have so many things that pass, after which its fault ends; None is all."""
    if count is None:
        return tap

    def counted(fault: FaultInstance, passing: Passing) -> Fates:
        if fault.ended_ns is not None:
            return passed(fault, passing)
        fault.ends_at_call(count)
        return tap(fault, passing)

    return counted


# ---- effects -----------------------------------------------------------------------------------


def passed(_: FaultInstance, passing: Passing) -> Fates:
    """Deliver it as if nothing were wrong."""
    return (Delivery(passing.message),)


def lose(_: FaultInstance, _given: Arguments) -> Tap:
    """Lose it."""
    return lambda *_: ()


def late(_: FaultInstance, given: Arguments) -> Tap:
    """Deliver it `by` seconds late."""
    by_ns = nanoseconds(given["by"])
    return lambda _, passing: (Delivery(passing.message, after_ns=by_ns),)


def repeat(_: FaultInstance, given: Arguments) -> Tap:
    """Deliver it `times` times, with ``after`` seconds between."""
    after_ns = nanoseconds(given["after"])
    return lambda _, passing: [
        Delivery(deepcopy(passing.message), after_ns=number * after_ns)
        for number in range(given["times"])
    ]


def nanoseconds(seconds: float) -> int:
    """Return seconds in ns."""
    return round(seconds * 1e9)


@contextmanager
def mistakes_of_test(what: str) -> Iterator[None]:
    """Raise what the robot or the world refuses as a ScenarioError."""
    try:
        yield
    except BtMissionError as error:
        raise ScenarioError(f"{what}: {error}") from error
