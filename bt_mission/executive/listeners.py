"""Callables that are called when something happens, and streams of items."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Generic, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


class Listeners(list[Callable[P, Any]]):
    """Callables that are called in the order of the list.

    One that raises an exception is removed, so that it cannot prevent a mission from ending.
    """

    def remove(self, listener: Callable[P, Any]) -> None:
        """Remove one; it need not be there."""
        if listener in self:
            super().remove(listener)

    def notify(self, *arguments: P.args, **named: P.kwargs) -> Sequence[Exception]:
        """Call each; return the exceptions that they raised."""
        raised: list[Exception] = []
        for listener in tuple(self):  # one of them may remove itself
            try:
                listener(*arguments, **named)
            except Exception as error:  # noqa: BLE001 - the caller decides what follows
                self.remove(listener)
                raised.append(error)
        return raised


class Stream(Generic[T]):
    """Hands each item to its subscribers, in the order in which they subscribed.

    A subscriber that raises an exception gets nothing more, so that it cannot keep a mission from
    its end.
    """

    def __init__(self) -> None:
        self._subscribers: tuple[tuple[Callable[[Any], object], tuple[type, ...]], ...] = ()
        self._takers: dict[type, tuple[Callable[[Any], object], ...]] = {}
        """The subscribers of each class of items so far."""
        self.raised: list[Exception] = []
        """Exceptions of subscribers; the owner of the stream takes them."""

    def __len__(self) -> int:
        return len(self._subscribers)

    def subscribe(self, take: Callable[[Any], object], *kinds: type) -> None:
        """Pass each item to this function from now on; or only those of some classes."""
        self._subscribers = (*self._subscribers, (take, kinds or (object,)))
        self._takers = {}

    def unsubscribe_all(self) -> None:
        """Send events to nobody."""
        self._subscribers = ()
        self._takers.clear()

    def unsubscribe(self, take: Callable[[Any], object]) -> None:
        """Stop passing items to it; it need not be subscribed."""
        self._subscribers = tuple(
            subscriber for subscriber in self._subscribers if subscriber[0] != take
        )
        self._takers = {}

    def emit(self, item: T) -> None:
        """Hand an item to every subscriber that takes its class."""
        kind = type(item)
        if kind not in self._takers:
            self._takers[kind] = tuple(
                take for take, kinds in self._subscribers if issubclass(kind, kinds)
            )
        for take in self._takers[kind]:
            try:
                take(item)
            except Exception as error:  # noqa: BLE001 - the owner decides what follows
                self.unsubscribe(take)
                self.raised.append(error)
