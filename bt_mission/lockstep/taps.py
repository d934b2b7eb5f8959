"""Taps: what passes between nodes, looked at and changed on its way to a receiver.

A tap sits where the executor takes a message, a request or a response for one receiver, before
the receiver's callback sees it. It decides what becomes of it: delivered now or later, once, more
often or not at all, as it is or changed; a request can also be answered in the receiver's place.
So anything can go wrong between sound nodes, at exact virtual times, without a wire to cut.

An action is three services and two topics (``/turn/_action/send_goal``, ``.../feedback``, ...),
and each of them can be tapped. Subscriptions to raw bytes, as recorders make them, are passed by:
they get what was sent.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from operator import itemgetter
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bt_mission.lockstep.serving import Rest


class Side(StrEnum):
    """What passes: a message of a topic, or one of the two directions of a service."""

    MESSAGE = "message"
    REQUEST = "request"
    RESPONSE = "response"


@dataclass(frozen=True)
class Passing:
    """Something on its way to a receiver.

    :param name: resolved name of the topic or service.
    :param message: the receiver's own copy, which may be changed.
    :param receiver: fully qualified name of the node that gets it.
    :param time_ns: virtual time, ns.
    """

    name: str
    side: Side
    message: Any
    receiver: str
    time_ns: int


@dataclass(frozen=True)
class Delivery:
    """Hand ``message`` to the receiver, ``after_ns`` from now."""

    message: Any
    after_ns: int = 0


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
        self._held: list[tuple[int, Any, Callable[[], Rest]]] = []
        self.is_open = False
        """Is there any tap? Where there is none, nothing is looked up."""

    def add(self, name: str, side: Side, tap: Tap) -> Callable[[], None]:
        """Have ``tap`` see what passes; gives a function that takes it away again.

        :param name: fully resolved, such as ``/scan`` or ``/turn/_action/send_goal``.
        """
        taps = self._taps[name, side]
        taps.append(tap)
        self.is_open = True

        def remove() -> None:
            if tap in taps:
                taps.remove(tap)

        return remove

    def next_due_ns(self) -> int | None:
        """When the next delivery that is held back is due, ns; None when there is none.

        One whose receiver is in the middle of another callback waits for its end.
        """
        return min((due for due, entity, _ in self._held if _is_free(entity)), default=None)

    def take_due(self, now_ns: int) -> list[tuple[Any, Callable[[], Rest]]]:
        """Take what is due out of what is held back, in order, each with its receiver."""
        if not self._held:
            return []
        due = [one for one in self._held if one[0] <= now_ns and _is_free(one[1])]
        for one in due:
            self._held.remove(one)
        due.sort(key=itemgetter(0))  # what is due at one time stays in the order of its coming
        return [(entity, deliver) for _, entity, deliver in due]

    def catch(
        self,
        entity: Any,
        passing: Passing,
        deliver: Callable[[Any], Rest],
        answer: Callable[[Any], Any] | None = None,
    ) -> bool:
        """Pass something through its taps; False when it has none, and nothing was done.

        :param deliver: hands a message to the receiver.
        :param answer: sends a response in the receiver's place.
        """
        taps = self._taps.get((passing.name, passing.side))
        if not taps:
            return False
        self._pass(_End(entity, deliver, answer), passing, tuple(taps))
        return True

    def _pass(self, end: _End, passing: Passing, taps: tuple[Tap, ...]) -> None:
        if not taps:
            self._hold(passing.time_ns, end, partial(end.deliver, passing.message))
            return
        for fate in taps[0](passing):
            due_ns = passing.time_ns + fate.after_ns
            later = replace(passing, message=fate.message, time_ns=due_ns)
            if isinstance(fate, Answer):
                if end.answer is None:
                    raise TypeError(f"a {passing.side} of {passing.name} cannot be answered")
                self._hold(due_ns, end, partial(end.answer, fate.message))
            elif fate.after_ns:
                self._hold(due_ns, end, partial(self._pass, end, later, taps[1:]))
            else:
                self._pass(end, later, taps[1:])

    def _hold(self, due_ns: int, end: _End, deliver: Callable[[], Rest]) -> None:
        self._held.append((due_ns, end.entity, deliver))


@dataclass(frozen=True)
class _End:
    """Where something goes."""

    entity: Any
    deliver: Callable[[Any], Rest]
    answer: Callable[[Any], Any] | None


def _is_free(entity: Any) -> bool:
    return bool(entity.callback_group.can_execute(entity))
