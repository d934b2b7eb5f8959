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

    def take(self, *, needs_statuses: bool) -> Heard:
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

    def find(self) -> tuple[FoundExecutive, ...]:
        """The executives that are there now, by name."""

    def attach(self, name: str) -> ExecutiveSource:
        """Listen to an executive, also one that is not there yet."""


NODE = "bt_mission"
"""The name of an executive's node, unless somebody has remapped it."""


@dataclass(frozen=True)
class AttachmentNews:
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

    def look(self) -> AttachmentNews:
        """Look for the executive that is wanted, or at what has become of it."""
        found = self._graph.find()
        if self.source is not None:
            name = self.source.name
            if any(one.is_foreign for one in found if one.name == name):
                self.source.close()  # its messages would be read as what they are not
                self.source, self._wanted = None, name
            return AttachmentNews()
        everybody = found
        found = _candidates(found, self._wanted)
        if not found:
            return AttachmentNews(
                nobody(self._wanted, everybody, self._graph.where), is_nobody=True
            )
        if len(found) > 1:
            return AttachmentNews(is_choice=True)
        if found[0].is_foreign:
            return AttachmentNews(f"{found[0].name}: {found[0].fault}")
        self.attach(found[0].name)
        return AttachmentNews(found[0].fault, is_new=True)


def wanted_name(text: str | None) -> str | None:
    """The full name that a user means: a name as it is, or that of the executive in a namespace."""
    if text is None:
        return None
    name = "/" + text.strip("/")
    return name if name.rpartition("/")[2] == NODE else f"{name.rstrip('/')}/{NODE}"


def _candidates(found: Sequence[FoundExecutive], wanted: str | None) -> tuple[FoundExecutive, ...]:
    return tuple(one for one in found if wanted in (None, one.name))


def choose(found: Sequence[FoundExecutive], wanted: str | None) -> FoundExecutive | None:
    """The executive that is meant; None where it is not there.

    Raises:
        BtMissionError: Where there are several and none is named, or its messages are of another
            version.
    """
    found = _candidates(found, wanted)
    if len(found) > 1:
        names = listed(one.name for one in found)
        raise BtMissionError(f"there are {len(found)} executives: name one of {names}")
    if found and found[0].is_foreign:
        raise BtMissionError(f"{found[0].name}: {found[0].fault}")
    return found[0] if found else None


def nobody(wanted: str | None, found: Sequence[FoundExecutive], where: str) -> str:
    """What to say while nobody is there to watch."""
    if wanted is not None and found:
        return f"{wanted} is not there ({where}); there is {listed(one.name for one in found)}"
    who = wanted or "an executive"
    return (
        f"no sign of {who} ({where}).\n"
        "Start one in another terminal, in the same ROS domain:\n"
        "  bt-mission run FILE --visible --speed 1   in a simulation of its own\n"
        "  bt-mission run FILE --attach              against the servers of a robot\n"
        "  bt-mission serve                          missions that others send"
    )
