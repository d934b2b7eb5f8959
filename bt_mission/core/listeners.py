"""Callables that are told what happens."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, ParamSpec

P = ParamSpec("P")


class Listeners(list[Callable[P, Any]]):
    """Callables that are called in the order of the list.

    One that raises an exception is called no more, so that it cannot keep a mission from its end.
    """

    def remove(self, listener: Callable[P, Any]) -> None:
        """Remove one; it need not be there."""
        if listener in self:
            super().remove(listener)

    def notify(self, *arguments: P.args, **named: P.kwargs) -> Sequence[Exception]:
        """Call each; return the exceptions that they raised."""
        raised: list[Exception] = []
        for listener in tuple(self):  # one of them may leave
            try:
                listener(*arguments, **named)
            except Exception as error:  # noqa: BLE001 - the caller decides what follows
                self.remove(listener)
                raised.append(error)
        return raised
