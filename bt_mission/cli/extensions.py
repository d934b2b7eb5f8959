"""What commands add to other ones: the types of the extension points of the command line.

The row of a command (:mod:`bt_mission.base.commands`) names what it adds; the command that it is
added to uses whatever the rows name.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from bt_mission.base.commands import added
from bt_mission.cli.parser import Option

if TYPE_CHECKING:
    from bt_mission.base.output import OutputFile
    from bt_mission.recording.replay.timeline import Timeline
    from bt_mission.sessions.served_missions import ServedMissions
    from bt_mission.sessions.session import Session

Kept = dict[str, str | int]
"""The files of a run by name, for output as JSON."""


@dataclass(frozen=True)
class ShowAddition:
    """A way to show a mission (`show`): to `run`, `serve` and `watch`.

    Attributes:
        options: Returns its options, given those of the command that it does not go with.
        is_wanted: Returns whether it is asked for.
        around: Shows a session while it is entered.
        beside: Shows the graph of this process from another one while it is entered.
        instead: Shows the graph until it is interrupted, and returns the exit code.
    """

    options: Callable[..., tuple[Option, ...]]
    is_wanted: Callable[[argparse.Namespace], bool]
    around: Callable[[argparse.Namespace, Session], AbstractContextManager[None]]
    beside: Callable[[argparse.Namespace], AbstractContextManager[None]]
    instead: Callable[[argparse.Namespace], int]


def show_options(*instead: str) -> tuple[Option, ...]:
    """Return the options of added ways to show a mission.

    Args:
        instead: Options of the command that they do not go with.
    """
    return tuple(option for shows in added("show") for option in shows.options(*instead))


def shown_by(options: argparse.Namespace) -> Sequence[ShowAddition]:
    """Return the added ways that are asked for."""
    return [shows for shows in added("show") if shows.is_wanted(options)]


@contextmanager
def shown_around(options: argparse.Namespace, session: Session) -> Iterator[None]:
    """Show a session in the added ways that are asked for."""
    with ExitStack() as stack:
        for shows in shown_by(options):
            stack.enter_context(shows.around(options, session))
        yield


@contextmanager
def shown_beside(options: argparse.Namespace) -> Iterator[None]:
    """Show the graph of this process, from others, in the added ways that are asked for."""
    with ExitStack() as stack:
        for shows in shown_by(options):
            stack.enter_context(shows.beside(options))
        yield


@dataclass(frozen=True)
class ServeAddition:
    """Missions for `serve` (`serve`).

    Attributes:
        options: Its options.
        missions: Returns what is served, or None where the options ask for nothing of it.
    """

    options: tuple[Option, ...]
    missions: Callable[[argparse.Namespace], ServedMissions | None]


@dataclass(frozen=True)
class ReplayAddition:
    """What can be started from a replay (`replay`).

    Attributes:
        key: Names it in the data of the page.
        start: Starts it from a terminal: the path of the recording, the instant in s, the words
            that were typed, and what gives the terminal back for a while. Returns the recording
            that it has made, or None.
        offer: Returns what the page of a robot offers of it.
    """

    key: str
    start: Callable[
        [Path, float, Sequence[str], Callable[[], AbstractContextManager[Any]]], Path | None
    ]
    offer: Callable[[Timeline, str], Mapping[str, Any]]


class RunFile(Protocol):
    """A file of a run while it is written."""

    @property
    def output(self) -> OutputFile:
        """The file."""

    def finish(self) -> Kept:
        """Close it; return what is to be said of it, by name."""


@dataclass(frozen=True)
class RunFileKind:
    """A kind of file that commands keep of a run (`recording`).

    Attributes:
        option: Names the file.
        open: Begins the file of a session; gives None where the session has none.
        lines: Returns lines about a file that is closed.
    """

    option: Option
    open: Callable[[Path, Session], AbstractContextManager[RunFile | None]]
    lines: Callable[[Kept], Iterable[str]]
