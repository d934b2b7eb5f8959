"""Taps read and change messages, requests and responses on their way to a receiver.

A tap sits where the executor takes a message, a request or a response for one receiver, before the
receiver's callback gets it. It decides how the item is delivered: now or later, once, several times
or not at all, as it is or changed. A request can also be answered in the receiver's place. So any
failure can be injected between valid nodes, at exact virtual times.

An action is three services and two topics (``/turn/_action/send_goal``, ``.../feedback``, ...), and
each of them can be tapped. Messages for a subscription to raw bytes are unpacked for its taps, and
packed again.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Coroutine, Iterable
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from operator import itemgetter
from typing import Any

PendingCallback = Coroutine[Any, Any, None] | None
"""The coroutine of a suspended callback; None if the callback has ended."""


class Side(StrEnum):
    """The kind of item: a message of a topic, or a direction of a service."""

    MESSAGE = "message"
    REQUEST = "request"
    RESPONSE = "response"


@dataclass(frozen=True)
class Passing:
    """Something on its way to a receiver.

    Args:
        name: Resolved name of the topic or service.
        message: The receiver's own copy, which may be changed.
        receiver: Fully qualified name of the node that gets it.
        time_ns: Virtual time, ns.
    """

    name: str
    side: Side
    message: Any
    receiver: str
    time_ns: int


class Gate:
    """Holds deliveries back until it is opened."""

    def __init__(self) -> None:
        self.opened_ns: int | None = None
        """The virtual time at which it opens, ns; None while it is closed."""

    def open(self, time_ns: int) -> None:
        """Open at a virtual time, ns. The earliest time counts."""
        if self.opened_ns is None or time_ns < self.opened_ns:
            self.opened_ns = time_ns


@dataclass(frozen=True)
class Delivery:
    """Hand ``message`` to the receiver, ``after_ns`` from now, and not before ``gate`` is open."""

    message: Any
    after_ns: int = 0
    gate: Gate | None = None


@dataclass(frozen=True)
class ServiceResponse:
    """Answer a request after ``after_ns`` with ``message``, instead of its receiver."""

    message: Any
    after_ns: int = 0


Tap = Callable[[Passing], Iterable[Delivery | ServiceResponse]]
"""Yields what is delivered in place of an item; without a yield the item is lost."""

ACTION_PARTS = {
    "goal": "send_goal",
    "cancel": "cancel_goal",
    "result": "get_result",
    "feedback": "feedback",
    "status": "status",
}
"""rclpy's names of the parts of an action, and the last word of their names in the graph."""


class Taps:
    """The taps of an executor, and the items that they hold back.

    Taps of one name and side apply in the order in which they were added: what the first delivers
    reaches the second at that time.
    """

    def __init__(self) -> None:
        self._taps: defaultdict[tuple[str, Side], list[Tap]] = defaultdict(list)
        self.held: list[_HeldItem] = []
        """Items that are delivered later."""
        self.is_open = False
        """Whether there is a tap. Without one, nothing is looked up."""
        self.can_take: Callable[[Any], bool] = _is_in_no_callback
        """Returns whether a receiver can take an item now."""

    def add(self, name: str, side: Side, tap: Tap) -> Callable[[], None]:
        """Add a tap. Return a function that removes it.

        Args:
            name: Fully resolved, such as ``/scan`` or ``/turn/_action/send_goal``.
        """
        taps = self._taps[name, side]
        taps.append(tap)
        self.is_open = True

        def remove() -> None:
            if tap in taps:
                taps.remove(tap)

        return remove

    def has(self, name: str, side: Side) -> bool:
        """Return whether there is a tap of this name and side."""
        return bool(self._taps.get((name, side)))

    def are_at(self, action: str) -> bool:
        """Return whether there is a tap at any part of an action."""
        parts = {f"{action}/_action/{part}" for part in ACTION_PARTS.values()}
        return any(taps and name in parts for (name, _), taps in self._taps.items())

    def next_due_ns(self) -> int | None:
        """Return when the next held item is due, ns; None without one.

        An item whose receiver is in a suspended callback waits for the end of that callback.
        """
        due = (held.due_ns for held in self.held if self.can_take(held.entity))
        return min((time_ns for time_ns in due if time_ns is not None), default=None)

    def take_due(self, now_ns: int) -> list[tuple[Any, Callable[[], PendingCallback]]]:
        """Take what is due out of what is held back, in order, each with its receiver."""
        if not self.held:
            return []
        due = [
            (due_ns, held)
            for held in self.held
            if (due_ns := held.due_ns) is not None
            and due_ns <= now_ns
            and self.can_take(held.entity)
        ]
        for _, held in due:
            self.held.remove(held)
        due.sort(key=itemgetter(0))  # items due at the same time keep the order of their arrival
        return [(held.entity, partial(held.deliver, now_ns)) for _, held in due]

    def catch(
        self,
        entity: Any,
        passing: Passing,
        deliver: Callable[[Any], PendingCallback],
        answer: Callable[[Any], Any] | None = None,
    ) -> bool:
        """Pass an item through its taps. Return False, without an effect, if it has none.

        Args:
            deliver: Passes a message to the receiver.
            answer: Sends a response in the receiver's place.
        """
        taps = self._taps.get((passing.name, passing.side))
        if not taps:
            return False
        self._pass(_Receiver(entity, deliver, answer), passing, tuple(taps))
        return True

    def _pass(self, end: _Receiver, passing: Passing, taps: tuple[Tap, ...]) -> None:
        if not taps:
            self._hold(passing.time_ns, end, lambda _: end.deliver(passing.message))
            return
        for fate in taps[0](passing):
            due_ns = passing.time_ns + fate.after_ns
            changed = replace(passing, message=fate.message)
            if isinstance(fate, ServiceResponse):
                if end.answer is None:
                    raise TypeError(f"a {passing.side} of {passing.name} cannot be answered")
                self._hold(due_ns, end, partial(_answer, end.answer, fate.message))
            elif fate.after_ns or fate.gate is not None:
                go_on = partial(self._pass_later, end, changed, taps[1:])
                self._hold(due_ns, end, go_on, fate.gate)
            else:
                self._pass(end, changed, taps[1:])

    def _pass_later(
        self, end: _Receiver, passing: Passing, taps: tuple[Tap, ...], time_ns: int
    ) -> None:
        self._pass(end, replace(passing, time_ns=time_ns), taps)

    def _hold(
        self,
        after_ns: int,
        end: _Receiver,
        deliver: Callable[[int], PendingCallback],
        gate: Gate | None = None,
    ) -> None:
        self.held.append(_HeldItem(after_ns, gate, end.entity, deliver))


@dataclass(frozen=True)
class _Receiver:
    """The receiver of an item."""

    entity: Any
    deliver: Callable[[Any], PendingCallback]
    answer: Callable[[Any], Any] | None


@dataclass(frozen=True, eq=False)
class _HeldItem:
    """An item that is delivered at a virtual time."""

    after_ns: int
    gate: Gate | None
    entity: Any
    deliver: Callable[[int], PendingCallback]

    @property
    def due_ns(self) -> int | None:
        """When it is due, ns; None while its gate is closed."""
        if self.gate is None:
            return self.after_ns
        opened_ns = self.gate.opened_ns
        return None if opened_ns is None else max(self.after_ns, opened_ns)


def _is_in_no_callback(receiver: Any) -> bool:
    return bool(receiver.callback_group.can_execute(receiver))


def _answer(answer: Callable[[Any], Any], message: Any, _time_ns: int) -> None:
    answer(message)
