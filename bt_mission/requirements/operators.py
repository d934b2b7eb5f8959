"""The operators of signal temporal logic over a stream of samples, each with bounded memory.

What looks back has its value at once (`Past`). What looks ahead has it when its window is over
(`Future`): it gives the values that have become final, in the order of their instants. Quantitative
semantics as in Donzé and Maler, "Robust satisfaction of temporal logic over real-valued signals"
(2010), over the samples that there are.

A negation is pushed down to the comparisons beforehand, so there is none here.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol, Self, TypeAlias

from typing_extensions import override

from bt_mission.requirements.samples import (
    Hope,
    Sample,
    Value,
    extreme,
    fails,
    holds,
    joined,
    least,
    most,
)

Window: TypeAlias = tuple[int, int | None]
"""From when to when, ns from the present instant; None: without an end."""


class Past(ABC):
    """A formula whose value depends on the present and the past alone."""

    is_settled_by_end = False
    """Does nothing in it change once the mission has ended?"""

    @abstractmethod
    def at(self, now_ns: int) -> Sample:
        """Return the value at the next instant."""


class Atom(Past):
    """A comparison of signals, or a signal that is true or false.

    Args:
        margin: Gives the margin, and None while a signal has no value; infinite where truth has no
            measure.
        is_strict: Does a margin of 0 fail?
        number: Its number in the formula.
    """

    def __init__(
        self,
        margin: Callable[[], float | None],
        number: int,
        *,
        is_strict: bool,
        is_settled_by_end: bool,
    ) -> None:
        self._margin = margin
        self._number = number
        self._is_strict = is_strict
        self.is_settled_by_end = is_settled_by_end

    @override
    def at(self, now_ns: int) -> Sample:
        margin = self._margin()
        if margin is None:
            return None
        return margin, margin > 0 or (margin == 0 and not self._is_strict), now_ns, self._number

    def __deepcopy__(self, memo: Any) -> Self:
        return self  # a copy of a formula reads the same signals


class Combinator(Protocol):
    """Gives the value of a formula at an instant from those of its parts, and of earlier ones."""

    def take(self, now_ns: int, /, *samples: Sample) -> Sample:
        """Return the value at the next instant, at which the parts have these."""


class Combined(Past):
    """A formula over parts that all look back."""

    def __init__(self, parts: Sequence[Past], combinator: Combinator) -> None:
        self._parts = parts
        self._combinator = combinator
        self.is_settled_by_end = all(part.is_settled_by_end for part in parts)

    @override
    def at(self, now_ns: int) -> Sample:
        return self._combinator.take(now_ns, *[part.at(now_ns) for part in self._parts])


class Joint:
    """`and` or `or`."""

    def __init__(self, *, all_of: bool) -> None:
        self._all_of = all_of

    def take(self, _now_ns: int, /, *samples: Sample) -> Sample:
        """Return the value at an instant, at which the parts have these."""
        return joined(samples, all_of=self._all_of)


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

    def __init__(self, window: Window, *, all_of: bool) -> None:
        self._from, self._to = window
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


class Since:
    """`left since right`, or, with `dual`, what holds where `not left since not right` fails."""

    def __init__(self, window: Window, *, dual: bool) -> None:
        self._from, self._to = window
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


class Future(ABC):
    """A formula whose value may depend on what comes."""

    is_settled_by_end = False

    @abstractmethod
    def step(self, now_ns: int) -> Iterable[Sample]:
        """Take the next instant; return the values that are final now, in order."""

    @abstractmethod
    def finish(self, hope: Hope) -> Iterable[Sample]:
        """Return the values that are left, with windows cut off at the end.

        Args:
            hope: What might still have come about after the end.
        """


class Present(Future):
    """A formula that looks back, among such that look ahead."""

    def __init__(self, past: Past) -> None:
        self.past = past
        self.is_settled_by_end = past.is_settled_by_end

    @override
    def step(self, now_ns: int) -> Iterable[Sample]:
        return (self.past.at(now_ns),)

    @override
    def finish(self, hope: Hope) -> Iterable[Sample]:
        return ()


class Aligned:
    """Values of several formulas, as soon as each has one for the same instant."""

    def __init__(self, parts: Sequence[Future]) -> None:
        self._parts = parts
        self._queues: list[deque[Sample]] = [deque() for _ in parts]

    def step(self, now_ns: int) -> Iterable[tuple[Sample, ...]]:
        """Take the next instant."""
        return self._ready([part.step(now_ns) for part in self._parts])

    def finish(self, hope: Hope) -> Iterable[tuple[Sample, ...]]:
        """Take what is left."""
        return self._ready([part.finish(hope) for part in self._parts])

    def _ready(self, found: Sequence[Iterable[Sample]]) -> Iterable[tuple[Sample, ...]]:
        for queue, samples in zip(self._queues, found, strict=True):
            queue.extend(samples)
        count = min(len(queue) for queue in self._queues)
        return [tuple(queue.popleft() for queue in self._queues) for _ in range(count)]


class Late(Future):
    """A formula over parts of which one looks ahead."""

    def __init__(self, parts: Sequence[Future], combinator: Combinator) -> None:
        self._aligned = Aligned(parts)
        self._combinator = combinator
        self._times: deque[int] = deque()
        self.is_settled_by_end = all(part.is_settled_by_end for part in parts)

    @override
    def step(self, now_ns: int) -> Iterable[Sample]:
        self._times.append(now_ns)
        return self._combine(self._aligned.step(now_ns))

    @override
    def finish(self, hope: Hope) -> Iterable[Sample]:
        return self._combine(self._aligned.finish(hope))

    def _combine(self, found: Iterable[tuple[Sample, ...]]) -> list[Sample]:
        return [self._combinator.take(self._times.popleft(), *ones) for ones in found]


class Ahead(Future):
    """At every instant of a window after now (`all_of`), or at some."""

    def __init__(self, operand: Future, start_ns: int, end_ns: int, *, all_of: bool) -> None:
        self._operand = operand
        self._start, self._end = start_ns, end_ns
        self._all_of = all_of
        self._extreme = Extreme(all_of=all_of)
        self._times: deque[int] = deque()
        self._pending: deque[int] = deque()
        self.is_settled_by_end = operand.is_settled_by_end

    @override
    def step(self, now_ns: int) -> Iterable[Sample]:
        self._times.append(now_ns)
        return self._take(self._operand.step(now_ns))

    def _take(self, samples: Iterable[Sample]) -> list[Sample]:
        final: list[Sample] = []
        for sample in samples:
            now_ns = self._times.popleft()
            while self._pending and self._pending[0] + self._end < now_ns:
                final.append(self._extreme.pick(self._pending.popleft() + self._start))
            self._pending.append(now_ns)
            self._extreme.add(now_ns, sample)
            while self._pending and self._pending[0] + self._end == now_ns:
                final.append(self._extreme.pick(self._pending.popleft() + self._start))
        return final

    @override
    def finish(self, hope: Hope) -> Iterable[Sample]:
        final = self._take(self._operand.finish(hope))
        for then_ns in self._pending:
            found = self._extreme.pick(then_ns + self._start)
            final.append(self._cut_off(found, then_ns, hope))
        self._pending.clear()
        return final

    def _cut_off(self, found: Sample, then_ns: int, hope: Hope) -> Sample:
        """Return the value over what is left of a window."""
        if self._all_of:
            return found
        if found is not None and found[1]:
            return found
        if hope.reaches(is_settled_by_end=self.is_settled_by_end):
            return holds(then_ns)
        return fails(then_ns) if found is None else found


class Until(Future):
    """`left until right` within a window, or its dual."""

    def __init__(
        self, left: Future, right: Future, start_ns: int, end_ns: int, *, dual: bool
    ) -> None:
        self._aligned = Aligned((left, right))
        self._start, self._end = start_ns, end_ns
        self._dual = dual
        self._times: deque[int] = deque()
        self._seen: deque[tuple[int, Sample, Sample]] = deque()
        self._pending: deque[int] = deque()
        self.is_settled_by_end = left.is_settled_by_end and right.is_settled_by_end

    @override
    def step(self, now_ns: int) -> Iterable[Sample]:
        self._times.append(now_ns)
        return self._take(self._aligned.step(now_ns))

    def _take(self, pairs: Iterable[tuple[Sample, ...]]) -> list[Sample]:
        final: list[Sample] = []
        for left, right in pairs:
            now_ns = self._times.popleft()
            while self._pending and self._pending[0] + self._end < now_ns:
                final.append(self._value(self._pending.popleft()))
            self._pending.append(now_ns)
            self._seen.append((now_ns, left, right))
            while self._pending and self._pending[0] + self._end == now_ns:
                final.append(self._value(self._pending.popleft()))
        return final

    def _value(self, then_ns: int) -> Sample:
        """Return the value at an instant; what was before it is dropped."""
        while self._seen and self._seen[0][0] < then_ns:
            self._seen.popleft()
        return until(self._seen, then_ns + self._start, then_ns, dual=self._dual)

    @override
    def finish(self, hope: Hope) -> Iterable[Sample]:
        final = self._take(self._aligned.finish(hope))
        for then_ns in self._pending:
            found = self._value(then_ns)
            is_open = hope.reaches(is_settled_by_end=self.is_settled_by_end) and not self._dual
            if is_open and (found is None or not found[1]) and self._is_kept():
                found = holds(then_ns)
            final.append(found)
        self._pending.clear()
        return final

    def _is_kept(self) -> bool:
        """Has the left side held up to the end, so that the right one might still come?"""
        return all(left is None or left[1] for _, left, _ in self._seen)


def until(
    seen: Iterable[tuple[int, Sample, Sample]], from_ns: int, then_ns: int, *, dual: bool
) -> Sample:
    """Return the value of `until` at the first of these instants; the right side counts later on.

    The left side must hold at every instant before the one at which the right side does.
    """
    found: list[Sample] = []
    kept = fails(then_ns) if dual else holds(then_ns)
    inner = most if dual else least
    for now_ns, left, right in seen:
        if now_ns >= from_ns:
            found.append(None if right is None else inner(kept, right))
        kept = kept if left is None else inner(kept, left)
    if not found:
        return holds(then_ns) if dual else fails(then_ns)
    return extreme(found, all_of=dual)
