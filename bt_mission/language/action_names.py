"""Actions that have a kind of node of their own in the mission language: ours, and plug-ins'."""

from __future__ import annotations

from collections.abc import Container
from importlib.metadata import entry_points

from bt_mission.core.actions import ActionName, declared

GROUP = "bt_mission.actions"
"""The entry points by which a package declares its actions; each is an `ActionName`."""

EXECUTE_MISSION = ActionName(
    name="execute_mission",
    type="bt_mission_interfaces/action/ExecuteMission",
    example={"path": "missions/square.yaml"},
)
"""The action of the executive."""

BROKEN: dict[str, str] = {}
"""Plug-ins that cannot be used, and why."""


def plugged(taken: Container[str]) -> dict[str, ActionName]:
    """Return the short names of installed packages; those that are broken go to `BROKEN`."""
    found: dict[str, ActionName] = {}
    for one in entry_points(group=GROUP):
        try:
            short = one.load()
        except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever a user's module raises
            BROKEN[one.name] = f"{one.value} cannot be imported: {type(error).__name__}: {error}"
            continue
        if not isinstance(short, ActionName):
            BROKEN[one.name] = f"{one.value}: expected an ActionName, got {type(short).__name__}"
        elif one.name in taken or not one.name.isidentifier():
            BROKEN[one.name] = f"{one.value}: its name is missing or already used"
        else:
            found[one.name] = short
    return found


_OURS = {
    known.kind: known
    for known in (*(one.known for one in declared().values()), EXECUTE_MISSION)
    if known.kind
}

ACTION_NAMES = {**_OURS, **plugged(_OURS)}
"""The kinds whose values are goals."""
