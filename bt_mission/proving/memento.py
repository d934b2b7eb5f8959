"""The state of the real objects of a running mission, taken and put back in place.

Objects stay the same, so that whatever refers to them remains true: closures, listeners, lists
that two objects share. Equal parts are shared between mementos.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from operator import is_
from typing import Any, TypeAlias

_CONTAINERS = frozenset({list, dict, set, deque})

_FIXED = frozenset(
    (
        *("children", "blackboards", "resets", "indices", "_paths", "evaluators"),
        *("tick_wrappers", "needs_physics", "_monitors", "_read", "_ended"),
    )
)
"""Attributes with containers that no step changes, or that belong to another object."""

_Saved: TypeAlias = tuple[Any, dict[str, Any], tuple[tuple[Any, Any], ...]]
"""An object, its attributes, and a copy of each container among them."""

Memento: TypeAlias = dict[int, _Saved]
"""What was saved of each object, by its `id`; the memento keeps the objects alive."""


class Keeper:
    """Takes and puts back the attributes of objects.

    Args:
        roots: Objects that are always there.
        dynamic: Returns the objects that come and go.
    """

    def __init__(self, roots: Iterable[Any], dynamic: Callable[[], Iterable[Any]]) -> None:
        self._roots = {id(entry): entry for entry in roots}
        self._dynamic = dynamic

    def take(self, earlier: Memento | None = None) -> Memento:
        """Return the present state; it shares with an earlier one what has not changed."""
        known = earlier or {}
        taken: Memento = {}
        for number, entry in self._roots.items():
            saved = known.get(number)
            if saved is None or saved[2] or entry.__dict__ != saved[1]:
                saved = _saved(entry, saved)
            taken[number] = saved
        for entry in self._dynamic():
            number = id(entry)
            if number not in taken:
                taken[number] = _saved(entry, known.get(number))
        return taken

    def put_back(self, memento: Memento) -> None:
        """Put the objects into the state that was taken."""
        for entry, attributes, containers in memento.values():
            entry.__dict__ = attributes.copy()
            for container, copy in containers:
                container.clear()
                if type(container) in (dict, set):
                    container.update(copy)
                else:
                    container.extend(copy)


def _saved(entry: Any, known: _Saved | None) -> _Saved:
    now = entry.__dict__
    if known is not None and now == known[1]:
        for container, copy in known[2]:
            if not _is_equal(container, copy):
                break
        else:
            return known
    return entry, now.copy(), _copies(now)


def _copies(attributes: Mapping[str, Any]) -> tuple[tuple[Any, Any], ...]:
    """Return each container among some attributes with a copy of it."""
    return tuple(
        [
            (value, value.copy())
            for name, value in attributes.items()
            if type(value) in _CONTAINERS and name not in _FIXED
        ]
    )


def _is_equal(container: Any, copy: Any) -> bool:
    """Is a container as it was copied? In a dict 0 and False are not the same."""
    if type(container) is not dict:
        return bool(container == copy)
    return len(container) == len(copy) and all(
        map(is_, container.values(), map(copy.get, container))
    )
