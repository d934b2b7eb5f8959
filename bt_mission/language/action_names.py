"""Actions that have a kind of node of their own in the mission language: ours, and plug-ins'."""

from __future__ import annotations

from collections.abc import Container
from importlib.metadata import entry_points

from bt_mission.base.actions import ActionName, declared

GROUP = "bt_mission.actions"
"""The entry points by which a package declares its actions; each is an `ActionName`."""

EXECUTE_MISSION = ActionName(
    name="execute_mission",
    type="bt_mission_interfaces/action/ExecuteMission",
    example={"path": "missions/square.yaml"},
)
"""The action of the executive."""

WORDS = frozenset(
    (
        *("sequence", "fallback", "parallel", "choose", "finally", "when", "repeat", "retry"),
        *("timeout", "invert", "force", "guard", "for_each", "check", "set", "wait", "log"),
        *("python", "service", "wait_for", "publish", "action", "tree"),
        *("name", "do", "else", "then", "inputs", "outputs", "memory", "weights", "readers"),
        *("succeed_when", "fail_when", "rest", "cancel_when", "on_cancel", "server_timeout"),
        *("acceptance_timeout", "feedback_timeout", "cancel_timeout", "uses"),
    )
)
"""The other kinds of nodes, and the modifiers: no action has such a name."""

BROKEN: dict[str, str] = {}
"""Plug-ins that cannot be used, and why."""


def plugged(taken: Container[str]) -> dict[str, ActionName]:
    """Return the short names of installed packages; those that are broken go to `BROKEN`."""
    names: dict[str, ActionName] = {}
    for entry_point in entry_points(group=GROUP):
        try:
            short = entry_point.load()
        except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever a user's module raises
            BROKEN[entry_point.name] = (
                f"{entry_point.value} cannot be imported: {type(error).__name__}: {error}"
            )
            continue
        if not isinstance(short, ActionName):
            BROKEN[entry_point.name] = (
                f"{entry_point.value}: expected an ActionName, got {type(short).__name__}"
            )
        elif entry_point.name in WORDS:
            BROKEN[entry_point.name] = (
                f"{entry_point.value}: {entry_point.name!r} is a word of the mission language; "
                "give the entry point another name"
            )
        elif entry_point.name in taken or not entry_point.name.isidentifier():
            BROKEN[entry_point.name] = f"{entry_point.value}: its name is missing or already used"
        else:
            names[entry_point.name] = short
    return names


_OURS = {
    known.kind: known
    for known in (*(action.known for action in declared().values()), EXECUTE_MISSION)
    if known.kind
}

ACTION_NAMES = {**_OURS, **plugged(_OURS)}
"""The kinds whose values are goals."""

BY_TYPE = {
    known.type: known
    for known in (*(action.known for action in declared().values()), *ACTION_NAMES.values())
}
"""Actions by their types: what they need, and the part that they move."""
