"""Formulas of signal temporal logic that look back: they have their value at once.

Quantitative semantics as in Donzé and Maler, "Robust satisfaction of temporal logic over
real-valued signals" (2010), over the samples that there are, with bounded memory. A negation is
pushed down to the comparisons beforehand, so there is none here.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, Self, TypeAlias

from typing_extensions import override

from bt_mission.requirements.samples import (
    Sample,
    Value,
    extreme,
    fails,
    holds,
    joined,
    least,
    most,
    negated,
)

Window: TypeAlias = tuple[int, int | None]
"""From when to when, ns from the present instant; None: without an end."""


class Past(ABC):
    """A formula whose value depends on the present and the past alone."""

    is_settled_by_end = False
    """Does nothing in it change once the mission has ended?"""
    remembers = False
    """Must it see every instant?"""

    @abstractmethod
    def at(self, now_ns: int) -> Sample:
        """Return the value at the next instant."""

    @property
    def is_highest(self) -> bool:
        """Does it hold by an infinite margin at every later instant?"""
        return False

    @property
    def alternatives(self) -> tuple[Past, ...]:
        """Parts that it is the `or` of; itself where it is none."""
        return (self,)


@dataclass(frozen=True)
class Monotone:
    """The signal that alone decides a margin, which never falls, or never rises, with its value.

    Attributes:
        read: Gives the signal's value.
        rises: Is the margin greater, not less, where the value is greater?
        limit: What the signal is compared with; None for one that is true or false.
    """

    read: Callable[[], Any]
    rises: bool
    limit: float | None = None


class Atom(Past):
    """A comparison of signals, or a signal that is true or false.

    Args:
        margin: Gives the margin, and None while a signal has no value; infinite where truth has no
            measure.
        number: Its number in the formula.
        is_strict: Does a margin of 0 fail?
        is_settled_by_end: Does it not change once the mission has ended?
        at_least: Gives what the margin is at least, where that costs less than the margin.
        of: The signal that alone decides the margin, if there is one.
    """

    def __init__(
        self,
        margin: Callable[[], float | None],
        number: int,
        *,
        is_strict: bool,
        is_settled_by_end: bool,
        at_least: Callable[[], float | None] | None = None,
        of: Monotone | None = None,
    ) -> None:
        self.margin = margin
        self.of = of if at_least is None else None
        self.at_least = at_least or margin
        self._number = number
        self.is_strict = is_strict
        self.is_settled_by_end = is_settled_by_end

    @override
    def at(self, now_ns: int) -> Sample:
        margin = self.margin()
        return None if margin is None else self.valued(margin, now_ns)

    def valued(self, margin: float, now_ns: int) -> Value:
        """Return the value of a margin."""
        return margin, margin > 0 or (margin == 0 and not self.is_strict), now_ns, self._number

    def __deepcopy__(self, memo: Any) -> Self:
        return self  # a copy of a formula reads the same signals


class Combinator(Protocol):
    """Gives the value of a formula at an instant from those of its parts, and of earlier ones."""

    @property
    def take(self) -> Callable[..., Sample]:
        """Gives the value at the next instant (ns), from the samples of the parts then."""

    @property
    def remembers(self) -> bool:
        """Must it see every instant?"""

    @property
    def moves(self) -> bool:
        """Can its value change while those of its parts stay as they are?"""


class Combined(Past):
    """A formula over parts that all look back."""

    def __init__(self, parts: Sequence[Past], combinator: Combinator) -> None:
        self._parts = parts
        self._combinator = combinator
        is_settled = all(part.is_settled_by_end for part in parts)
        self.is_settled_by_end = is_settled and not combinator.moves
        self.remembers = combinator.remembers or any(part.remembers for part in parts)

    @override
    def at(self, now_ns: int) -> Sample:
        return self._combinator.take(now_ns, *[part.at(now_ns) for part in self._parts])

    @property
    @override
    def alternatives(self) -> tuple[Past, ...]:
        if isinstance(self._combinator, Joint) and not self._combinator.all_of:
            return tuple(one for part in self._parts for one in part.alternatives)
        return (self,)


class Joint:
    """`and` or `or`."""

    remembers = False
    moves = False

    def __init__(self, *, all_of: bool) -> None:
        self.all_of = all_of

    def take(self, _now_ns: int, /, *samples: Sample) -> Sample:
        """Return the value at an instant, at which the parts have these."""
        return joined(samples, all_of=self.all_of)


class Ever(Past):
    """At every instant up to now (`all_of`), or at some."""

    remembers = True

    def __init__(self, operand: Past, *, all_of: bool) -> None:
        self._operand = operand
        self._pick = least if all_of else most
        self._limit = -math.inf if all_of else math.inf
        self._value: Sample = None
        self.is_settled_by_end = operand.is_settled_by_end

    @override
    def at(self, now_ns: int) -> Sample:
        value = self._value
        if value is None or value[0] != self._limit or self._operand.remembers:
            sample = self._operand.at(now_ns)
            if sample is not None:
                self._value = value = sample if value is None else self._pick(value, sample)
        return value

    @property
    @override
    def is_highest(self) -> bool:
        value = self._value
        return value is not None and value[0] == math.inf == self._limit


class Extreme:
    """The least or the most of the values in a window that moves on."""

    def __init__(self, *, all_of: bool) -> None:
        self._pick = least if all_of else most
        self._queue: deque[tuple[int, Value]] = deque()

    def add(self, now_ns: int, sample: Sample) -> None:
        """Take a value; those that can never be picked any more are dropped."""
        if sample is None:
            return
        queue, pick = self._queue, self._pick
        while queue and pick(sample, queue[-1][1]) is sample and sample[:2] != queue[-1][1][:2]:
            queue.pop()
        queue.append((now_ns, sample))

    def pick(self, from_ns: int) -> Sample:
        """Return the extreme from an instant on; later calls ask for later instants."""
        queue = self._queue
        while queue and queue[0][0] < from_ns:
            queue.popleft()
        return queue[0][1] if queue else None


class Historically:
    """At every instant of a window before now (`all_of`), or at some: `previously`."""

    remembers = True

    def __init__(self, window: Window, *, all_of: bool) -> None:
        self._from, self._to = window
        self.moves = window != (0, None)
        self._all_of = all_of
        self._pick = least if all_of else most
        self._extreme = Extreme(all_of=all_of)
        self._waiting: deque[tuple[int, Sample]] = deque()
        self._so_far: Sample = None
        self._has_entered = False

    def take(self, now_ns: int, operand: Sample, /) -> Sample:
        """Return the value at the next instant, at which the operand has this one."""
        waiting = self._waiting
        waiting.append((now_ns, operand))
        while waiting and waiting[0][0] <= now_ns - self._from:
            then_ns, sample = waiting.popleft()
            self._has_entered = True
            if self._to is not None:
                self._extreme.add(then_ns, sample)
            elif sample is not None:
                so_far = self._so_far
                self._so_far = sample if so_far is None else self._pick(so_far, sample)
        if not self._has_entered:
            return holds(now_ns) if self._all_of else fails(now_ns)
        return self._so_far if self._to is None else self._extreme.pick(now_ns - self._to)


class Filled:
    """A word that looks back, without a value until its window is full.

    Args:
        combinator: What gives its value.
        full_ns: When the window, and those of its parts, are full, since the start.
    """

    remembers = True
    moves = True

    def __init__(self, combinator: Combinator, full_ns: int) -> None:
        self._combinator = combinator
        self._full_ns = full_ns

    def take(self, now_ns: int, /, *samples: Sample) -> Sample:
        """Return the value at the next instant, at which the parts have these."""
        value = self._combinator.take(now_ns, *samples)
        return value if now_ns >= self._full_ns else None


class EdgeOf:
    """The instants at which a condition begins, or with `ends` ceases, to be true.

    Before the first instant nothing is true. Where the condition has no value, it stays as it was.
    """

    remembers = True
    moves = False

    def __init__(self, *, ends: bool, positive: bool) -> None:
        self._ends, self._positive = ends, positive
        self._before = fails(0)

    def take(self, _now_ns: int, sample: Sample, /) -> Sample:
        """Return the value at the next instant, at which the condition has this one."""
        if sample is None:
            return None
        before, self._before = self._before, sample
        old, new = (before, negated(sample)) if self._ends else (negated(before), sample)
        value = least(new, old)
        return value if self._positive else negated(value)


class Since:
    """`left since right`, or, with `dual`, what holds where `not left since not right` fails."""

    remembers = True

    def __init__(self, window: Window, *, dual: bool) -> None:
        self._from, self._to = window
        self.moves = window != (0, None)
        self._inner = most if dual else least
        self._dual = dual
        self._starts: deque[tuple[int, Sample]] = deque()

    def take(self, now_ns: int, kept: Sample, right: Sample, /) -> Sample:
        """Return the value at the next instant, at which left and right have these."""
        starts = self._starts
        for index, (then_ns, value) in enumerate(starts):
            if value is not None and kept is not None:
                starts[index] = (then_ns, self._inner(value, kept))
        starts.append((now_ns, right))
        if self._to is not None:
            while starts[0][0] < now_ns - self._to:
                starts.popleft()
        else:
            self._merge(now_ns)
        inside = [value for then_ns, value in starts if then_ns <= now_ns - self._from]
        if not inside:
            return holds(now_ns) if self._dual else fails(now_ns)
        return extreme(inside, all_of=self._dual)

    def _merge(self, now_ns: int) -> None:
        """Make one of the starts that are in the window for good, so that memory stays bounded."""
        starts = self._starts
        while len(starts) > 1 and starts[1][0] <= now_ns - self._from:
            _, first = starts.popleft()
            then_ns, second = starts.popleft()
            starts.appendleft((then_ns, extreme((first, second), all_of=self._dual)))
