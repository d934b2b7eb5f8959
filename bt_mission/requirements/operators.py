"""Operators of signal temporal logic, evaluated one instant after another with bounded memory.

Quantitative semantics as in Donzé and Maler, "Robust satisfaction of temporal logic over
real-valued signals" (2010), over the samples of the run. The negation is pushed down to the
comparisons, so no operator negates.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Self, TypeAlias

from typing_extensions import override

from bt_mission.requirements.samples import (
    Sample,
    Truncation,
    Value,
    extreme,
    false_at,
    joined,
    least,
    most,
    negated,
    true_at,
)

Window: TypeAlias = tuple[int, float]
"""Start and end of a window, ns from the present instant; the end may be infinite."""

ALL_TIME: Window = (0, math.inf)


class CompiledFormula(ABC):
    """A formula at every instant.

    Attributes:
        looks_ahead: Can its value depend on later instants?
        is_settled_by_end: Does its value not change once the mission has ended?
    """

    looks_ahead = False
    is_settled_by_end = False

    @abstractmethod
    def at(self, now_ns: int) -> Sample:
        """Take the next instant, and return the value at it; not for one that looks ahead."""

    def step(self, now_ns: int) -> Sequence[Sample]:
        """Take the next instant; return the values that are final now, in the order of instants."""
        return (self.at(now_ns),)

    def finish(self, _truncation: Truncation) -> Sequence[Sample]:
        """Return the values of the remaining instants, whose windows the end cuts off."""
        return ()


class Atom(CompiledFormula):
    """A comparison of signals, or a signal that is true or false.

    Args:
        margin: Gives the margin, and None while a signal has no value; infinite where truth has no
            measure.
        number: Its number in the formula.
        is_strict: Is it false with a margin of 0?
        is_settled_by_end: Does it not change once the mission has ended?
        lower_bound: Gives a lower bound of the margin, where that costs less than the margin.
    """

    def __init__(
        self,
        margin: Callable[[], float | None],
        number: int,
        *,
        is_strict: bool,
        is_settled_by_end: bool,
        lower_bound: Callable[[], float | None] | None = None,
    ) -> None:
        self._margin, self._number, self._is_strict = margin, number, is_strict
        self.is_settled_by_end = is_settled_by_end
        self.lower_bound = lower_bound

    @override
    def at(self, now_ns: int) -> Sample:
        margin = self._margin()
        if margin is None or math.isnan(margin):
            return None
        return margin, margin > 0 or (margin == 0 and not self._is_strict), now_ns, self._number

    def __deepcopy__(self, memo: Any) -> Self:
        return self  # a copy of a formula reads the same signals


class Aligned:
    """The values of several formulas, as soon as each has its value at the same instant."""

    def __init__(self, parts: Sequence[CompiledFormula]) -> None:
        self._parts = parts
        self.looks_ahead = any(part.looks_ahead for part in parts)
        self._times: deque[int] = deque()
        self._queues: list[deque[Sample]] = [deque() for _ in parts]

    def step(self, now_ns: int) -> list[tuple[int, tuple[Sample, ...]]]:
        """Take the next instant; return instants with the values of the parts."""
        if not self.looks_ahead:
            return [(now_ns, tuple([part.at(now_ns) for part in self._parts]))]
        self._times.append(now_ns)
        return self._ready([part.step(now_ns) for part in self._parts])

    def finish(self, truncation: Truncation) -> list[tuple[int, tuple[Sample, ...]]]:
        """Return the remaining instants, with the values of the parts."""
        return self._ready([part.finish(truncation) for part in self._parts])

    def _ready(self, added: Iterable[Sequence[Sample]]) -> list[tuple[int, tuple[Sample, ...]]]:
        for queue, samples in zip(self._queues, added, strict=True):
            queue.extend(samples)
        return [
            (self._times.popleft(), tuple([queue.popleft() for queue in self._queues]))
            for _ in range(min(map(len, self._queues)))
        ]


class Operator(CompiledFormula):
    """A formula whose value follows from those of its parts, then and before.

    Args:
        parts: The formulas that it joins.
        moves: Can its value change while those of its parts stay the same?
        full_ns: It has no value before this time since the start.
    """

    def __init__(
        self, parts: Sequence[CompiledFormula], *, moves: bool = False, full_ns: int = 0
    ) -> None:
        self._parts = parts
        self._aligned = Aligned(parts)
        self._full_ns = full_ns
        self.looks_ahead = self._aligned.looks_ahead
        self.is_settled_by_end = not moves and all(part.is_settled_by_end for part in parts)

    @override
    def at(self, now_ns: int) -> Sample:
        value = self._value(now_ns, *[part.at(now_ns) for part in self._parts])
        return value if now_ns >= self._full_ns else None

    @override
    def step(self, now_ns: int) -> Sequence[Sample]:
        return self._values(self._aligned.step(now_ns))

    @override
    def finish(self, truncation: Truncation) -> Sequence[Sample]:
        return self._values(self._aligned.finish(truncation))

    def _values(self, instants: Iterable[tuple[int, tuple[Sample, ...]]]) -> list[Sample]:
        values = []
        for then_ns, samples in instants:
            value = self._value(then_ns, *samples)
            values.append(value if then_ns >= self._full_ns else None)
        return values

    @abstractmethod
    def _value(self, now_ns: int, /, *samples: Sample) -> Sample:
        """Return the value at the next instant, at which the parts have these."""


class Joint(Operator):
    """`and` (`all_of`) or `or`."""

    def __init__(self, parts: Sequence[CompiledFormula], *, all_of: bool) -> None:
        super().__init__(parts)
        self._all_of = all_of

    @override
    def _value(self, now_ns: int, /, *samples: Sample) -> Sample:
        return joined(samples, all_of=self._all_of)


class Edge(Operator):
    """The instants at which a condition starts, or with `ends` ends, to be true.

    Before the first instant nothing is true. Where the condition has no value, it stays as it was.
    """

    def __init__(self, operand: CompiledFormula, *, ends: bool, positive: bool) -> None:
        super().__init__([operand])
        self._ends, self._positive = ends, positive
        self._previous = false_at(0)

    @override
    def _value(self, now_ns: int, /, *samples: Sample) -> Sample:
        (sample,) = samples
        if sample is None:
            return None
        previous, self._previous = self._previous, sample
        old, new = (previous, negated(sample)) if self._ends else (negated(previous), sample)
        value = least(new, old)
        return value if self._positive else negated(value)


class Extreme:
    """The least (`all_of`) or the most of the values in a window that moves on."""

    def __init__(self, *, all_of: bool) -> None:
        self._pick = least if all_of else most
        self._queue: deque[tuple[int, Value]] = deque()

    def add(self, now_ns: int, sample: Sample) -> None:
        """Add a value, and drop those that can never be picked any more."""
        if sample is None:
            return
        queue, pick = self._queue, self._pick
        while queue and pick(sample, queue[-1][1]) is sample and sample[:2] != queue[-1][1][:2]:
            queue.pop()
        queue.append((now_ns, sample))

    def pick(self, from_ns: float) -> Sample:
        """Return the extreme from an instant on; later calls give later instants."""
        queue = self._queue
        while queue and queue[0][0] < from_ns:
            queue.popleft()
        return queue[0][1] if queue else None


class Historically(Operator):
    """True at every instant of a window before now (`all_of`), or at some: `previously`."""

    def __init__(
        self, parts: Sequence[CompiledFormula], window: Window, *, full_ns: int, all_of: bool
    ) -> None:
        super().__init__(parts, moves=window != ALL_TIME, full_ns=full_ns)
        self._start, self._end = window
        self._all_of = all_of
        self._pick = least if all_of else most
        self._extreme = Extreme(all_of=all_of)
        self._waiting: deque[tuple[int, Sample]] = deque()
        self._extreme_so_far: Sample = None
        self._has_entered = False

    @override
    def _value(self, now_ns: int, /, *samples: Sample) -> Sample:
        (operand,) = samples
        waiting = self._waiting
        waiting.append((now_ns, operand))
        while waiting and waiting[0][0] <= now_ns - self._start:
            then_ns, sample = waiting.popleft()
            self._has_entered = True
            if self._end < math.inf:
                self._extreme.add(then_ns, sample)
            elif sample is not None:
                before = self._extreme_so_far
                self._extreme_so_far = sample if before is None else self._pick(before, sample)
        if not self._has_entered:
            return true_at(now_ns) if self._all_of else false_at(now_ns)
        return (
            self._extreme.pick(now_ns - self._end) if self._end < math.inf else self._extreme_so_far
        )


class Since(Operator):
    """`left since right`, or its dual: the negation of `not left since not right`."""

    def __init__(
        self, parts: Sequence[CompiledFormula], window: Window, *, full_ns: int, dual: bool
    ) -> None:
        super().__init__(parts, moves=window != ALL_TIME, full_ns=full_ns)
        self._start, self._end = window
        self._dual = dual
        self._inner = most if dual else least
        self._starts: deque[tuple[int, Sample]] = deque()

    @override
    def _value(self, now_ns: int, /, *samples: Sample) -> Sample:
        left, right = samples
        starts = self._starts
        for index, (then_ns, value) in enumerate(starts):
            if value is not None and left is not None:
                starts[index] = (then_ns, self._inner(value, left))
        starts.append((now_ns, right))
        while starts[0][0] < now_ns - self._end:
            starts.popleft()
        if self._end == math.inf:
            self._merge(now_ns)
        inside = [value for then_ns, value in starts if then_ns <= now_ns - self._start]
        if not inside:
            return true_at(now_ns) if self._dual else false_at(now_ns)
        return extreme(inside, all_of=self._dual)

    def _merge(self, now_ns: int) -> None:
        """Merge the starts that never leave the window, so that memory stays bounded."""
        starts = self._starts
        while len(starts) > 1 and starts[1][0] <= now_ns - self._start:
            _, first = starts.popleft()
            then_ns, second = starts.popleft()
            starts.appendleft((then_ns, extreme((first, second), all_of=self._dual)))


class LookingAhead(CompiledFormula):
    """A formula about a bounded window after now, over its parts.

    Args:
        parts: The formulas that it joins.
        window: From now on.
        all_of: Can an instant in the window make it false, rather than true?
    """

    looks_ahead = True

    def __init__(self, parts: Sequence[CompiledFormula], window: Window, *, all_of: bool) -> None:
        self._aligned = Aligned(parts)
        self._start, self._end = window
        self._all_of = all_of
        self._pending: deque[int] = deque()
        self.is_settled_by_end = all(part.is_settled_by_end for part in parts)

    @override
    def at(self, now_ns: int) -> Sample:
        raise AssertionError("its value is final later")

    @override
    def step(self, now_ns: int, *, is_wanted: bool = True) -> Sequence[Sample]:
        """Take the next instant, whose own value is returned later if it is wanted."""
        return self._final(self._aligned.step(now_ns), is_wanted=is_wanted)

    def _final(
        self, instants: Iterable[tuple[int, tuple[Sample, ...]]], *, is_wanted: bool = True
    ) -> list[Sample]:
        final = []
        for now_ns, samples in instants:
            while self._pending and self._pending[0] + self._end < now_ns:
                final.append(self._value(self._pending.popleft()))
            if is_wanted:
                self._pending.append(now_ns)
            self._add(now_ns, *samples)
            while self._pending and self._pending[0] + self._end == now_ns:
                final.append(self._value(self._pending.popleft()))
        return final

    @override
    def finish(self, truncation: Truncation) -> Sequence[Sample]:
        final = self._final(self._aligned.finish(truncation))
        final += [self._truncated(then_ns, truncation) for then_ns in self._pending]
        self._pending.clear()
        return final

    def _truncated(self, then_ns: int, truncation: Truncation) -> Sample:
        """Return the value at an instant whose window the end of the run cuts off."""
        value = self._value(then_ns)
        if value is not None and value[1] is not self._all_of:  # decided
            return value
        if self._all_of:
            can_fail = truncation.refutes(is_settled_by_end=self.is_settled_by_end)
            return false_at(then_ns) if can_fail and self._is_open else value
        can_come = truncation.fulfils(is_settled_by_end=self.is_settled_by_end) and self._is_open
        return true_at(then_ns) if can_come else value

    @property
    def _is_open(self) -> bool:
        """Can instants after those so far decide, for the instant asked last?"""
        return True

    @abstractmethod
    def _add(self, now_ns: int, /, *samples: Sample) -> None:
        """Take the values of the parts at the next instant."""

    @abstractmethod
    def _value(self, then_ns: int) -> Sample:
        """Return the value at an instant over its window so far; later calls give later ones."""


class Ahead(LookingAhead):
    """True at every instant of a bounded window after now (`all_of`), or at some.

    Attributes:
        has_memory: Do its parts have to take every instant?
    """

    def __init__(self, parts: Sequence[CompiledFormula], window: Window, *, all_of: bool) -> None:
        super().__init__(parts, window, all_of=all_of)
        self.has_memory = not all(isinstance(part, Atom) for part in parts)
        self._extreme = Extreme(all_of=all_of)

    @override
    def _add(self, now_ns: int, /, *samples: Sample) -> None:
        self._extreme.add(now_ns, *samples)

    @override
    def _value(self, then_ns: int) -> Sample:
        return self._extreme.pick(then_ns + self._start)

    @override
    def _truncated(self, then_ns: int, truncation: Truncation) -> Sample:
        value = super()._truncated(then_ns, truncation)
        return false_at(then_ns) if value is None and not self._all_of else value


class Until(LookingAhead):
    """`left until right` within a bounded window, or with `all_of` its dual.

    The left side must be true at every instant before the one at which the right side is.
    """

    def __init__(self, parts: Sequence[CompiledFormula], window: Window, *, all_of: bool) -> None:
        super().__init__(parts, window, all_of=all_of)
        self._seen: deque[tuple[int, Sample, Sample]] = deque()

    @override
    def _add(self, now_ns: int, /, *samples: Sample) -> None:
        left, right = samples
        self._seen.append((now_ns, left, right))

    @override
    def _value(self, then_ns: int) -> Sample:
        while self._seen and self._seen[0][0] < then_ns:
            self._seen.popleft()
        inner = most if self._all_of else least
        kept = false_at(then_ns) if self._all_of else true_at(then_ns)
        reached: list[Sample] = []
        for now_ns, left, right in self._seen:
            if now_ns >= then_ns + self._start:
                reached.append(None if right is None else inner(kept, right))
            kept = kept if left is None else inner(kept, left)
        if not reached:
            return true_at(then_ns) if self._all_of else false_at(then_ns)
        return extreme(reached, all_of=self._all_of)

    @property
    @override
    def _is_open(self) -> bool:
        return all(left is None or left[1] is not self._all_of for _, left, _ in self._seen)
