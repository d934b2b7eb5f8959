"""Which of several executives is meant."""

from __future__ import annotations

from collections.abc import Sequence

from bt_mission.core.diagnostics import listed
from bt_mission.core.errors import BtMissionError
from bt_mission.events.source import FoundExecutive

NODE = "bt_mission"
"""The name of an executive's node, unless somebody has remapped it."""


def wanted_name(text: str | None) -> str | None:
    """The full name that a user means: a name as it is, or that of the executive in a namespace."""
    if text is None:
        return None
    name = "/" + text.strip("/")
    return name if name.rpartition("/")[2] == NODE else f"{name.rstrip('/')}/{NODE}"


def choose(found: Sequence[FoundExecutive], wanted: str | None) -> FoundExecutive | None:
    """The executive that is meant; None where it is not there.

    :raises BtMissionError: where there are several and none is named, or its messages are of
        another version.
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
