"""Values that remember when they last changed, so that each page gets only what is new to it."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, Generic, TypeVar

Key = TypeVar("Key", bound=Hashable)


class RevisedValues(Generic[Key]):
    """Values by key, the last changed ones last.

    A page that is slow misses values in between and never the newest; nothing is queued for it.
    """

    def __init__(self) -> None:
        self._kept: dict[Key, tuple[int, Any]] = {}

    def put(self, key: Key, value: Any, revision: int) -> bool:
        """Keep a value; gives whether it is another one than before."""
        before = self._kept.get(key)
        if before is not None and before[1] == value:
            return False
        self._kept.pop(key, None)
        self._kept[key] = (revision, value)
        return True

    def since(self, revision: int) -> dict[Key, Any]:
        """What has changed after a revision, in the order of the changes."""
        found: list[tuple[Key, Any]] = []
        for key in reversed(self._kept):
            changed, value = self._kept[key]
            if changed <= revision:
                break
            found.append((key, value))
        return dict(reversed(found))

    def drop(self, key: Key) -> None:
        """Forget a value; pages that have it keep it."""
        self._kept.pop(key, None)

    def clear(self) -> None:
        """Forget all of them."""
        self._kept.clear()
