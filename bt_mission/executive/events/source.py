"""The source of a view's data, and the target of its user's requests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from bt_mission.base.diagnostics import listed
from bt_mission.base.errors import BtMissionError
from bt_mission.executive.events.messages import Batch, CameraImage, Robot


class Verb(StrEnum):
    """A request that a user may make of a mission."""

    PAUSE = "pause"
    PAUSE_KEEPING_GOALS = "pause, goals continue"
    RESUME = "resume"
    STEP = "step"
    STOP = "stop"
    BREAK = "breakpoint"
    UNBREAK = "remove the breakpoint"


@dataclass(frozen=True)
class ControlRequest:
    """A request; ``node`` is the path of a node for a breakpoint."""

    verb: Verb
    node: str = ""


@dataclass(frozen=True)
class ControlResponse:
    """The response to a request, as text."""

    is_done: bool
    text: str


@dataclass(frozen=True)
class ListedExecutive:
    """An executive of the graph.

    Args:
        name: The name of its node, such as ``/robot1/bt_mission``.
        problem: Why it cannot be watched, or only with care; empty without a problem.
        is_foreign: Its messages are of another version and cannot be read.
    """

    name: str
    problem: str = ""
    is_foreign: bool = False

    @property
    def namespace(self) -> str:
        """Of its robot, without the slash at the end."""
        return self.name.rpartition("/")[0]


@dataclass(frozen=True)
class Received:
    """The messages received since the last call; of the camera, the newest image."""

    messages: tuple[Batch, ...] = ()
    robot: tuple[Robot, ...] = ()
    answers: tuple[ControlResponse, ...] = ()
    image: CameraImage | None = None


class ExecutiveSource(Protocol):
    """One executive, and its robot."""

    name: str

    @property
    def is_there(self) -> bool:
        """Whether the executive is in the graph."""

    def take(self, *, needs_statuses: bool) -> Received:
        """Return what was received since the last call, without waiting.

        Args:
            needs_statuses: Request all statuses, unless that was done just before.
        """

    def send(self, command: ControlRequest) -> None:
        """Send a request; a later :meth:`take` has the response."""

    def watch_camera(self, *, is_on: bool) -> None:
        """Hear the robot's camera, or no longer: its pictures are drawn while somebody does."""

    def close(self) -> None:
        """Listen no longer."""


class Graph(Protocol):
    """The executives of a graph."""

    where: str
    """The place that is searched, for messages."""

    def serve(self) -> None:
        """Handle what was received, without waiting."""

    def find(self) -> tuple[ListedExecutive, ...]:
        """The executives that are there now, by name."""

    def attach(self, name: str) -> ExecutiveSource:
        """Return the source of an executive, even if it is not in the graph yet."""


NODE = "bt_mission"
"""The name of an executive's node, unless somebody has remapped it."""


@dataclass(frozen=True)
class AttachmentChange:
    """The result of a search for executives.

    Args:
        text: A message for the user; empty without one.
        is_new: Whether an executive was just attached.
        is_nobody: Whether the executive that is wanted is missing.
        is_choice: Whether there are several, and the user has to choose one.
    """

    text: str = ""
    is_new: bool = False
    is_nobody: bool = False
    is_choice: bool = False


class Attachment:
    """The attachment to one executive of a graph.

    Args:
        wanted: Its name; None attaches the only one.
    """

    def __init__(self, graph: Graph, wanted: str | None) -> None:
        self.source: ExecutiveSource | None = None
        self._graph = graph
        self._wanted = wanted

    def attach(self, name: str) -> None:
        """Watch this executive from now on, and no other."""
        if self.source is not None:
            self.source.close()
        self.source, self._wanted = self._graph.attach(name), name

    def look(self) -> AttachmentChange:
        """Search for the executive that is wanted, or check the one that is attached."""
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
            return AttachmentChange(f"{executives[0].name}: {executives[0].problem}")
        self.attach(executives[0].name)
        return AttachmentChange(executives[0].problem, is_new=True)


def wanted_name(text: str | None) -> str | None:
    """Return the full name of an executive: a name as it is, or that in a namespace."""
    if text is None:
        return None
    name = "/" + text.strip("/")
    return name if name.rpartition("/")[2] == NODE else f"{name.rstrip('/')}/{NODE}"


def _candidates(
    executives: Sequence[ListedExecutive], wanted: str | None
) -> tuple[ListedExecutive, ...]:
    return tuple(executive for executive in executives if wanted in (None, executive.name))


def choose(executives: Sequence[ListedExecutive], wanted: str | None) -> ListedExecutive | None:
    """Return the wanted executive; None if it is missing.

    Raises:
        BtMissionError: There are several and none is named, or its messages are of another version.
    """
    executives = _candidates(executives, wanted)
    if len(executives) > 1:
        names = listed(executive.name for executive in executives)
        raise BtMissionError(f"{len(executives)} executives: choose one of {names}", code="BT-912")
    if executives and executives[0].is_foreign:
        raise BtMissionError(f"{executives[0].name}: {executives[0].problem}", code="BT-915")
    return executives[0] if executives else None


def nobody(wanted: str | None, executives: Sequence[ListedExecutive], where: str) -> str:
    """Return the message while the wanted executive is missing."""
    if wanted is not None and executives:
        names = listed(executive.name for executive in executives)
        return f"no executive {wanted} ({where}); available: {names}"
    who = wanted or "an executive"
    return (
        f"{who} was not found ({where}).\n"
        "Start one in another terminal, in the same ROS domain:\n"
        "  bt-mission run FILE --visible --speed 1   in a new simulation\n"
        "  bt-mission run FILE --attach              against the servers of a robot\n"
        "  bt-mission serve                          missions sent as goals"
    )
