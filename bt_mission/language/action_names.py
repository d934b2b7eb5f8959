"""Actions that have a kind of node of their own in the mission language: ours, and plug-ins'."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cache, cached_property

from typing_extensions import override

from bt_mission.base.actions import ActionName, declared
from bt_mission.base.entry_points import entry_points

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
"""Plug-ins that cannot be used, and why; complete once :func:`plugged` has been called."""


@cache
def plugged() -> Mapping[str, ActionName]:
    """Return the short names of installed packages; those that are broken go to `BROKEN`.

    To look for them takes a tenth of a second, so it is done when a name is unknown here.
    """
    names: dict[str, ActionName] = {}
    for entry_point in entry_points(GROUP):
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
        elif entry_point.name in _OURS or not entry_point.name.isidentifier():
            BROKEN[entry_point.name] = f"{entry_point.value}: its name is missing or already used"
        else:
            names[entry_point.name] = short
    return names


class KnownNames(Mapping[str, ActionName]):
    """Our actions by a key, and after them those of plug-ins, which are loaded when one is asked.

    Args:
        ours: Our own.
        key: Returns the key of an action of a plug-in, from that and its short name.
    """

    def __init__(
        self, ours: Mapping[str, ActionName], key: Callable[[str, ActionName], str]
    ) -> None:
        self._ours, self._key = ours, key

    @cached_property
    def _all(self) -> Mapping[str, ActionName]:
        theirs = {self._key(short, known): known for short, known in plugged().items()}
        return {**self._ours, **theirs}

    @override
    def __getitem__(self, key: str) -> ActionName:
        known = self._ours.get(key)
        if known is not None:
            return known
        if key in WORDS:
            raise KeyError(key)
        return self._all[key]

    @override
    def __iter__(self) -> Iterator[str]:
        return iter(self._all)

    @override
    def __len__(self) -> int:
        return len(self._all)


_OURS = {
    known.kind: known
    for known in (*(action.known for action in declared().values()), EXECUTE_MISSION)
    if known.kind
}

ACTION_NAMES = KnownNames(_OURS, lambda short, _: short)
"""The kinds whose values are goals."""

BY_TYPE = KnownNames(
    {
        known.type: known
        for known in (*(each.known for each in declared().values()), *_OURS.values())
    },
    lambda _, known: known.type,
)
"""Actions by their types: what they need, and the part that they move."""
