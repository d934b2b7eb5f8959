"""Where a view has its facts from, and where it sends what its user wants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from bt_mission.core.diagnostics import listed
from bt_mission.core.errors import BtMissionError
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
class ListedExecutive:
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
class Received:
    """What has come since the last time; of the camera the newest picture."""

    messages: tuple[told.Batch, ...] = ()
    robot: tuple[told.Robot, ...] = ()
    answers: tuple[ControlResponse, ...] = ()
    image: told.CameraImage | None = None


class ExecutiveSource(Protocol):
    """One executive, and its robot."""

    name: str

    @property
    def is_there(self) -> bool:
        """Is the executive in the graph?"""

    def take(self, *, needs_statuses: bool) -> Received:
        """What has come since the last time, without waiting.

        Args:
            needs_statuses: Ask for all statuses, unless that was done a moment ago.
        """

    def send(self, command: ControlRequest) -> None:
        """Pass a wish on; its answer comes with a later :meth:`take`."""

    def watch_camera(self, *, is_on: bool) -> None:
        """Hear the robot's camera, or no longer: its pictures are drawn while somebody does."""

    def close(self) -> None:
        """Listen no longer."""


class Graph(Protocol):
    """Where executives are found."""

    where: str
    """What is looked through, for people."""

    def serve(self) -> None:
        """Receive what has come, without waiting."""

    def find(self) -> tuple[ListedExecutive, ...]:
        """The executives that are there now, by name."""

    def attach(self, name: str) -> ExecutiveSource:
        """Listen to an executive, also one that is not there yet."""


NODE = "bt_mission"
"""The name of an executive's node, unless somebody has remapped it."""


@dataclass(frozen=True)
class AttachmentChange:
    """What came of a look round.

    Args:
        text: For the user; empty where there is nothing to say.
        is_new: Has an executive just been found?
        is_nobody: Is nobody there who is wanted?
        is_choice: Are there several, of which the user has to choose one?
    """

    text: str = ""
    is_new: bool = False
    is_nobody: bool = False
    is_choice: bool = False


class Attachment:
    """Holds on to one executive of a graph.

    Args:
        wanted: Its name; None takes the only one.
    """

    def __init__(self, graph: Graph, wanted: str | None) -> None:
        self.source: ExecutiveSource | None = None
        self._graph = graph
        self._wanted = wanted

    def attach(self, name: str) -> None:
        """Watch this one from now on, and no other."""
        if self.source is not None:
            self.source.close()
        self.source, self._wanted = self._graph.attach(name), name

    def look(self) -> AttachmentChange:
        """Look for the executive that is wanted, or at what has become of it."""
        executives = self._graph.find()
        if self.source is not None:
            name = self.source.name
            if any(executive.is_foreign for executive in executives if executive.name == name):
                self.source.close()  # its messages would be read as what they are not
                self.source, self._wanted = None, name
            return AttachmentChange()
        everybody = executives
        executives = _candidates(executives, self._wanted)
        if not executives:
            return AttachmentChange(
                nobody(self._wanted, everybody, self._graph.where), is_nobody=True
            )
        if len(executives) > 1:
            return AttachmentChange(is_choice=True)
        if executives[0].is_foreign:
            return AttachmentChange(f"{executives[0].name}: {executives[0].fault}")
        self.attach(executives[0].name)
        return AttachmentChange(executives[0].fault, is_new=True)


def wanted_name(text: str | None) -> str | None:
    """The full name that a user means: a name as it is, or that of the executive in a namespace."""
    if text is None:
        return None
    name = "/" + text.strip("/")
    return name if name.rpartition("/")[2] == NODE else f"{name.rstrip('/')}/{NODE}"


def _candidates(
    executives: Sequence[ListedExecutive], wanted: str | None
) -> tuple[ListedExecutive, ...]:
    return tuple(executive for executive in executives if wanted in (None, executive.name))


def choose(executives: Sequence[ListedExecutive], wanted: str | None) -> ListedExecutive | None:
    """The executive that is meant; None where it is not there.

    Raises:
        BtMissionError: Where there are several and none is named, or its messages are of another
            version.
    """
    executives = _candidates(executives, wanted)
    if len(executives) > 1:
        names = listed(executive.name for executive in executives)
        raise BtMissionError(f"there are {len(executives)} executives: name one of {names}")
    if executives and executives[0].is_foreign:
        raise BtMissionError(f"{executives[0].name}: {executives[0].fault}")
    return executives[0] if executives else None


def nobody(wanted: str | None, executives: Sequence[ListedExecutive], where: str) -> str:
    """What to say while nobody is there to watch."""
    if wanted is not None and executives:
        names = listed(executive.name for executive in executives)
        return f"{wanted} is not there ({where}); there is {names}"
    who = wanted or "an executive"
    return (
        f"no sign of {who} ({where}).\n"
        "Start one in another terminal, in the same ROS domain:\n"
        "  bt-mission run FILE --visible --speed 1   in a simulation of its own\n"
        "  bt-mission run FILE --attach              against the servers of a robot\n"
        "  bt-mission serve                          missions that others send"
    )
