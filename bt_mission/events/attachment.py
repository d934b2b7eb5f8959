"""Who of a graph is watched: found, lost, taken by another version, chosen among several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bt_mission.core.diagnostics import listed
from bt_mission.core.errors import BtMissionError
from bt_mission.events.source import ExecutiveSource, FoundExecutive, Graph

NODE = "bt_mission"
"""The name of an executive's node, unless somebody has remapped it."""


@dataclass(frozen=True)
class AttachmentNews:
    """What came of a look round.

    Args:
        text: For the user; empty where there is nothing to say.
        is_new: Has an executive just been found?
        is_choice: Are there several, of which the user has to choose one?
    """

    text: str = ""
    is_new: bool = False
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
        if self._wanted is not None:
            found = tuple(one for one in found if one.name == self._wanted)
        if not found:
            return AttachmentNews(
                f"no sign of {self._wanted or 'an executive'} ({self._graph.where})"
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


def choose(found: Sequence[FoundExecutive], wanted: str | None) -> FoundExecutive | None:
    """The executive that is meant; None where it is not there.

    Raises:
        BtMissionError: Where there are several and none is named, or its messages are of another
            version.
    """
    if wanted is not None:
        found = [one for one in found if one.name == wanted]
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
        "`bt-mission run FILE --visible`, `bt-mission run FILE --attach` and `bt-mission serve` "
        "can be watched."
    )
