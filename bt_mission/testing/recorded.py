"""The messages of one topic, as they came."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from typing import Any


class Recorded:
    """Messages of a topic with the virtual times at which they came.

    :param name: resolved name of the topic.
    """

    def __init__(self, name: str, start_ns: int) -> None:
        self.name = name
        self._start_ns = start_ns
        self._times_ns: list[int] = []
        self._messages: list[Any] = []

    def add(self, time_ns: int, message: Any) -> None:
        """Write a message down."""
        self._times_ns.append(time_ns)
        self._messages.append(message)

    @property
    def messages(self) -> tuple[Any, ...]:
        """All of them, in order."""
        return tuple(self._messages)

    @property
    def times(self) -> tuple[float, ...]:
        """When each came, s since the start of the run."""
        return tuple((time_ns - self._start_ns) / 1e9 for time_ns in self._times_ns)

    @property
    def last(self) -> Any:
        """The newest; None before the first."""
        return self._messages[-1] if self._messages else None

    def at(self, time_ns: int) -> Any:
        """The newest at a virtual time; None before the first."""
        number = bisect_right(self._times_ns, time_ns)
        return self._messages[number - 1] if number else None

    def __len__(self) -> int:
        return len(self._messages)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._messages)
