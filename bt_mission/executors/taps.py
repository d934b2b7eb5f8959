"""Taps: what passes between nodes, looked at and changed on its way to a receiver.

A tap sits where the executor takes a message, a request or a response for one receiver, before
the receiver's callback sees it. It decides what becomes of it: delivered now or later, once, more
often or not at all, as it is or changed; a request can also be answered in the receiver's place.
So anything can go wrong between sound nodes, at exact virtual times, without a wire to cut.

An action is three services and two topics (``/turn/_action/send_goal``, ``.../feedback``, ...),
and each of them can be tapped. What a subscription to raw bytes is sent is unpacked for its taps,
and packed again.
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
"""The coroutine of a callback that was begun; None when the callback has ended."""


class Side(StrEnum):
    """What passes: a message of a topic, or one of the two directions of a service."""

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
    """Holds deliveries back, for as long as it takes."""

    def __init__(self) -> None:
        self.opened_ns: int | None = None
        """The virtual time from which on it lets through, ns; None while it is closed."""

    def open(self, time_ns: int) -> None:
        """Let through from a virtual time on; the earliest that is said counts."""
        if self.opened_ns is None or time_ns < self.opened_ns:
            self.opened_ns = time_ns


@dataclass(frozen=True)
class Delivery:
    """Hand ``message`` to the receiver, ``after_ns`` from now, and not before ``gate`` is open."""

    message: Any
    after_ns: int = 0
    gate: Gate | None = None


@dataclass(frozen=True)
class Answer:
    """Answer a request, ``after_ns`` from now, with ``message``; the receiver never sees it."""

    message: Any
    after_ns: int = 0


Tap = Callable[[Passing], Iterable[Delivery | Answer]]
"""Gives what becomes of something that passes; nothing, and it is lost."""

ACTION_PARTS = {
    "goal": "send_goal",
    "cancel": "cancel_goal",
    "result": "get_result",
    "feedback": "feedback",
    "status": "status",
}
"""What rclpy calls the parts of an action, and the last word of their names in the graph."""


class Taps:
    """The taps of an executor, and what they hold back.

    Taps of one name and side are passed through in the order in which they were added: what the
    first delivers reaches the second at that time.
    """

    def __init__(self) -> None:
        self._taps: defaultdict[tuple[str, Side], list[Tap]] = defaultdict(list)
        self.held: list[_Held] = []
        """What is to be delivered later."""
        self.is_open = False
        """Is there any tap? Where there is none, nothing is looked up."""

    def add(self, name: str, side: Side, tap: Tap) -> Callable[[], None]:
        """Have ``tap`` see what passes; gives a function that takes it away again.

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
        """Is there a tap of this name and side?"""
        return bool(self._taps.get((name, side)))

    def are_at(self, action: str) -> bool:
        """Is there a tap at any part of an action?"""
        parts = {f"{action}/_action/{part}" for part in ACTION_PARTS.values()}
        return any(taps and name in parts for (name, _), taps in self._taps.items())

    def next_due_ns(self) -> int | None:
        """When the next delivery that is held back is due, ns; None when there is none.

        One whose receiver is in the middle of another callback waits for its end.
        """
        due = (held.due_ns for held in self.held if held.is_free)
        return min((time_ns for time_ns in due if time_ns is not None), default=None)

    def take_due(self, now_ns: int) -> list[tuple[Any, Callable[[], PendingCallback]]]:
        """Take what is due out of what is held back, in order, each with its receiver."""
        if not self.held:
            return []
        due = [
            (due_ns, held)
            for held in self.held
            if (due_ns := held.due_ns) is not None and due_ns <= now_ns and held.is_free
        ]
        for _, held in due:
            self.held.remove(held)
        due.sort(key=itemgetter(0))  # what is due at one time stays in the order of its coming
        return [(held.entity, partial(held.deliver, now_ns)) for _, held in due]

    def catch(
        self,
        entity: Any,
        passing: Passing,
        deliver: Callable[[Any], PendingCallback],
        answer: Callable[[Any], Any] | None = None,
    ) -> bool:
        """Pass something through its taps; False when it has none, and nothing was done.

        Args:
            deliver: Hands a message to the receiver.
            answer: Sends a response in the receiver's place.
        """
        taps = self._taps.get((passing.name, passing.side))
        if not taps:
            return False
        self._pass(_End(entity, deliver, answer), passing, tuple(taps))
        return True

    def _pass(self, end: _End, passing: Passing, taps: tuple[Tap, ...]) -> None:
        if not taps:
            self._hold(passing.time_ns, end, lambda _: end.deliver(passing.message))
            return
        for fate in taps[0](passing):
            due_ns = passing.time_ns + fate.after_ns
            changed = replace(passing, message=fate.message)
            if isinstance(fate, Answer):
                if end.answer is None:
                    raise TypeError(f"a {passing.side} of {passing.name} cannot be answered")
                self._hold(due_ns, end, partial(_answer, end.answer, fate.message))
            elif fate.after_ns or fate.gate is not None:
                go_on = partial(self._pass_later, end, changed, taps[1:])
                self._hold(due_ns, end, go_on, fate.gate)
            else:
                self._pass(end, changed, taps[1:])

    def _pass_later(self, end: _End, passing: Passing, taps: tuple[Tap, ...], time_ns: int) -> None:
        self._pass(end, replace(passing, time_ns=time_ns), taps)

    def _hold(
        self,
        after_ns: int,
        end: _End,
        deliver: Callable[[int], PendingCallback],
        gate: Gate | None = None,
    ) -> None:
        self.held.append(_Held(after_ns, gate, end.entity, deliver))


@dataclass(frozen=True)
class _End:
    """Where something goes."""

    entity: Any
    deliver: Callable[[Any], PendingCallback]
    answer: Callable[[Any], Any] | None


@dataclass(frozen=True, eq=False)
class _Held:
    """Something held back: to be delivered, at a virtual time that is told."""

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

    @property
    def is_free(self) -> bool:
        """Can its receiver take it, or is that in the middle of another callback?"""
        return bool(self.entity.callback_group.can_execute(self.entity))


def _answer(answer: Callable[[Any], Any], message: Any, _time_ns: int) -> None:
    answer(message)
