"""Where a view has its facts from, and where it sends what its user wants."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from bt_mission.events import messages as told


class Verb(StrEnum):
    """What a user may want of a mission."""

    PAUSE = "pause"
    PAUSE_KEEPING_GOALS = "pause, goals run on"
    RESUME = "resume"
    STEP = "step"
    STOP = "stop"
    BREAK = "breakpoint"
    UNBREAK = "remove the breakpoint"


@dataclass(frozen=True)
class ControlRequest:
    """A wish; ``node`` is the path of the node that a breakpoint is about."""

    verb: Verb
    node: str = ""


@dataclass(frozen=True)
class ControlResponse:
    """What became of a wish, in words."""

    is_done: bool
    text: str


@dataclass(frozen=True)
class FoundExecutive:
    """An executive of the graph.

    Args:
        name: Of its node, such as ``/robot1/bt_mission``.
        fault: Why it cannot be watched, or has to be with care; empty where nothing is wrong.
        is_foreign: Its messages are of another version: they cannot be read.
    """

    name: str
    fault: str = ""
    is_foreign: bool = False

    @property
    def namespace(self) -> str:
        """Of its robot, without the slash at the end."""
        return self.name.rpartition("/")[0]


@dataclass(frozen=True)
class Heard:
    """What has come since the last time."""

    messages: tuple[told.Told, ...] = ()
    robot: tuple[told.Robot, ...] = ()
    answers: tuple[ControlResponse, ...] = ()


class ExecutiveSource(Protocol):
    """One executive, and its robot."""

    name: str

    @property
    def is_there(self) -> bool:
        """Is the executive in the graph?"""

    def take(self, *, needs_statuses: bool) -> Heard:
        """What has come since the last time, without waiting.

        Args:
            needs_statuses: Ask for all statuses, unless that was done a moment ago.
        """

    def send(self, command: ControlRequest) -> None:
        """Pass a wish on; its answer comes with a later :meth:`take`."""

    def close(self) -> None:
        """Listen no longer."""


class Graph(Protocol):
    """Where executives are found."""

    where: str
    """What is looked through, for people."""

    def serve(self) -> None:
        """Receive what has come, without waiting."""

    def find(self) -> tuple[FoundExecutive, ...]:
        """The executives that are there now, by name."""

    def attach(self, name: str) -> ExecutiveSource:
        """Listen to an executive, also one that is not there yet."""
