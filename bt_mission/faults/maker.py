"""How a fault is declared: a method of :class:`Maker` that gives what begins it."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from copy import deepcopy
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar

from rclpy.node import Node

from bt_mission.core.errors import BtMissionError
from bt_mission.faults.errors import ScenarioError
from bt_mission.faults.fault import Begin, Fates, Fault, FaultInstance, Tap
from bt_mission.virtual_time import Delivery, Passing


class PlayedServer(Protocol):
    """An action server that a test plays."""

    goals: list[Any]

    @property
    def goal(self) -> Any:
        """Its newest goal."""

    @property
    def node(self) -> Node:
        """Owns its services and topics."""

    def forget(self) -> None:
        """Know nothing of its goals any more."""

    def offer(self, node: Node, /) -> None:
        """Offer the action by another node."""


class FaultStages(Protocol):
    """The stages for which faults are made."""

    @property
    def scripted(self) -> Mapping[str, PlayedServer]:
        """The servers that a test plays, by the full names of their actions."""

    def node(self, name: str) -> Node:
        """Return a node of the test's own."""


class Maker:
    """Makes faults for one stage; the classes that do so have it for their base."""

    def __init__(self, stages: FaultStages) -> None:
        self._stages = stages


M = TypeVar("M", bound=Maker)
P = ParamSpec("P")

TOLD_WHERE_CHANGED = ("share", "in_order", "size")
"""Parameters that are left out where they are as by default; so are those that are 0 or off."""


def makes_fault(method: Callable[Concatenate[M, P], Begin]) -> Callable[Concatenate[M, P], Fault]:
    """Declare a fault: a method that checks its arguments, and gives what begins it.

    Its name and arguments become those of the fault; after ``lasting`` seconds it ends by itself.
    """
    what, signature = method.__name__, inspect.signature(method)

    @functools.wraps(method)
    def make(self: M, /, *args: P.args, **kwargs: P.kwargs) -> Fault:
        begin = method(self, *args, **kwargs)
        given = signature.bind(self, *args, **kwargs).arguments
        lasting = given.get("lasting")
        if lasting is not None and not lasting > 0:
            raise ScenarioError(f"{what}: expected lasting above 0 s, got {lasting!r}")
        return Fault(what, _told(signature, given), begin, lasting)

    make.__annotations__ = {**method.__annotations__, "return": Fault.__name__}
    return make


def _told(signature: inspect.Signature, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of a fault by their names, without those that change nothing."""
    told: dict[str, Any] = {}
    for name, parameter in signature.parameters.items():
        value = given.get(name, parameter.default)
        if name in ("self", "lasting") or value is parameter.empty:
            continue
        if parameter.kind is parameter.VAR_KEYWORD:
            told |= value
        elif not _changes_nothing(parameter, value):
            told[name] = value
    return {name: value for name, value in told.items() if value is not None}


def _changes_nothing(parameter: inspect.Parameter, value: Any) -> bool:
    default = parameter.default
    if default is None or default is parameter.empty:
        return False
    return (not default or parameter.name in TOLD_WHERE_CHANGED) and bool(value == default)


@contextmanager
def mistakes_of_test(what: str) -> Iterator[None]:
    """Raise what the robot or the world refuses as a ScenarioError."""
    try:
        yield
    except BtMissionError as error:
        raise ScenarioError(f"{what}: {error}") from error


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
