"""Numbers computed from the past: counts of edges, means, rates, and values at an edge.

Each takes every instant in turn, and remembers no more than its window holds.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Self

from typing_extensions import override

from bt_mission.base.stamps import NS
from bt_mission.language.expressions.values import Plain
from bt_mission.requirements.operators import Atom, CompiledFormula
from bt_mission.requirements.samples import Sample


class MeasuredValue(ABC):
    """The value of a measure, one instant after another.

    Args:
        read: Gives the present value of what is measured; None while it has none.
        edge: The edges that are counted, or at the last of which the value is taken.
        window_ns: How far it looks back; it may be infinite.
        full_ns: It has no value before this time since the start.

    Attributes:
        value: The value at the newest instant; None without one.
    """

    def __init__(
        self,
        read: Callable[[], Plain | None],
        edge: CompiledFormula | None,
        *,
        window_ns: float,
        full_ns: int,
    ) -> None:
        self.value: Plain | None = None
        self._read, self._edge = read, edge
        self._window_ns, self._full_ns = window_ns, full_ns
        self._queue: deque[tuple[int, float]] = deque()

    def step(self, now_ns: int) -> None:
        """Take the next instant."""
        value = self._next(now_ns)
        self.value = value if now_ns >= self._full_ns else None

    @abstractmethod
    def _next(self, now_ns: int) -> Plain | None:
        """Return the value at the next instant."""

    def _is_at_edge(self, now_ns: int) -> bool:
        sample = None if self._edge is None else self._edge.at(now_ns)
        return sample is not None and sample[1]

    def _number(self) -> float | None:
        value = self._read()
        if not isinstance(value, int | float) or math.isnan(value):
            return None
        return float(value)

    def _drop_old(self, now_ns: int) -> None:
        while self._queue and self._queue[0][0] < now_ns - self._window_ns:
            self._queue.popleft()


class Count(MeasuredValue):
    """How many edges there were."""

    _unbounded = 0

    @override
    def _next(self, now_ns: int) -> Plain | None:
        if self._is_at_edge(now_ns):
            if self._window_ns == math.inf:
                self._unbounded += 1
            else:
                self._queue.append((now_ns, 1.0))
        self._drop_old(now_ns)
        return self._unbounded + len(self._queue)


class Mean(MeasuredValue):
    """The mean of the values at the instants of the window; those without one are left out.

    The sum is taken again at each instant, and rounded once, so that no error grows.
    """

    @override
    def _next(self, now_ns: int) -> Plain | None:
        number = self._number()
        if number is not None:
            self._queue.append((now_ns, number))
        self._drop_old(now_ns)
        if not self._queue:
            return None
        try:
            return math.fsum(value for _, value in self._queue) / len(self._queue)
        except (OverflowError, ValueError):  # beyond all numbers, or of both infinities
            return None


class Rate(MeasuredValue):
    """The difference to the value before, by the time between the two, per second."""

    _before: tuple[int, float] | None = None

    @override
    def _next(self, now_ns: int) -> Plain | None:
        number, before = self._number(), self._before
        if number is None:
            return None
        self._before = (now_ns, number)
        if before is None or before[0] == now_ns:
            return None
        rate = (number - before[1]) / ((now_ns - before[0]) / NS)
        return None if math.isnan(rate) else rate


class ValueAt(MeasuredValue):
    """The value at the last instant at which the edge was there."""

    _value: Plain | None = None

    @override
    def _next(self, now_ns: int) -> Plain | None:
        if self._is_at_edge(now_ns):
            self._value = self._read()
        return self._value


MEASURED_VALUES: dict[str, type[MeasuredValue]] = {
    "count": Count,
    "mean": Mean,
    "rate": Rate,
    "value": ValueAt,
}


class MeasuredCondition(CompiledFormula):
    """A condition over measures, inner ones first; each sees every instant."""

    def __init__(self, atom: Atom, measures: Sequence[MeasuredValue], *, moves: bool) -> None:
        self._atom = atom
        self._measures = measures
        self.is_settled_by_end = atom.is_settled_by_end and not moves

    @override
    def at(self, now_ns: int) -> Sample:
        for measure in self._measures:
            measure.step(now_ns)
        return self._atom.at(now_ns)

    def __deepcopy__(self, memo: Any) -> Self:
        return self  # what ends a run takes no further instant
