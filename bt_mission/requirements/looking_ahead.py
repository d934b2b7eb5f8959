"""Formulas that look ahead: their values are final when their windows are over.

Each takes one instant after another, and gives the values that have become final, in the order of
their instants. Windows that the end of the run cuts off are settled by :class:`samples.Hope`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterable, Sequence

from typing_extensions import override

from bt_mission.requirements.looking_back import Combinator, Extreme, Past
from bt_mission.requirements.samples import (
    Hope,
    Sample,
    extreme,
    fails,
    holds,
    least,
    most,
)


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


class LateCombined(Future):
    """A formula over parts of which one looks ahead."""

    def __init__(self, parts: Sequence[Future], combinator: Combinator) -> None:
        self._aligned = Aligned(parts)
        self._combinator = combinator
        self._times: deque[int] = deque()
        is_settled = all(part.is_settled_by_end for part in parts)
        self.is_settled_by_end = is_settled and not combinator.moves

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
            if not self._all_of:
                is_settled = self.is_settled_by_end
                found = cut_off(found, then_ns, hope, is_settled_by_end=is_settled)
            elif hope is Hope.WORST:
                found = refuted(found, then_ns)
            final.append(found)
        self._pending.clear()
        return final


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
            if hope is Hope.WORST and self._dual and not self._is_released():
                found = refuted(found, then_ns)
            final.append(found)
        self._pending.clear()
        return final

    def _is_released(self) -> bool:
        """Of the dual: has the left side held, so that it no longer depends on the right one?"""
        return any(left is not None and left[1] for _, left, _ in self._seen)

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


def refuted(found: Sample, then_ns: int) -> Sample:
    """Return the value of `always` where what comes after the end is the worst."""
    return fails(then_ns) if found is None or found[1] else found


def cut_off(found: Sample, then_ns: int, hope: Hope, *, is_settled_by_end: bool) -> Sample:
    """Return the value of `eventually` over what the end of the run leaves of its window."""
    if found is not None and found[1]:
        return found
    if hope.reaches(is_settled_by_end=is_settled_by_end):
        return holds(then_ns)
    return fails(then_ns) if found is None else found
