"""A formula at the start of a run: its verdict so far, and in the end."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterable, Sequence

from typing_extensions import override

from bt_mission.requirements.looking_ahead import Aligned, Future
from bt_mission.requirements.looking_back import Atom
from bt_mission.requirements.samples import (
    Hope,
    Sample,
    fails,
    holds,
    joined,
    least,
    most,
)

NEVER = 1 << 63
"""Later than any instant, ns."""


class Root(ABC):
    """A formula at the instant of the start.

    Attributes:
        value: Its value by what was seen so far.
        decided: Whether it holds, where nothing that comes can change that.
    """

    value: Sample = None
    decided: bool | None = None
    guard: Atom | None = None
    """The comparison that can spare a step by itself, if one can."""
    is_spared_above = True
    """Does it spare a step where the guard has a better margin, or where it has a worse one?"""
    due_ns: int = NEVER
    """From this instant on, no step is spared."""

    @property
    def is_settled(self) -> bool:
        """Can nothing that comes change its value any more, nor whether it is decided?"""
        return False

    def is_spared_now(self) -> bool:
        """Would another step with the present value of the guard's signal change nothing?"""
        return False

    @abstractmethod
    def step(self, now_ns: int) -> None:
        """Take the next instant."""

    @abstractmethod
    def finish(self, hope: Hope) -> Sample:
        """Return the value of the whole run, with windows cut off at its end.

        Args:
            hope: What might still have come about after the end.
        """


class Throughout(Root):
    """At every instant of a window from the start on (`all_of`), or at some."""

    def __init__(self, operand: Future, start_ns: int, end_ns: int | None, *, all_of: bool) -> None:
        self._operand = operand
        self._start, self._end = start_ns, end_ns
        self._is_everything = start_ns == 0 and end_ns is None
        self._all_of = all_of
        self._pick = least if all_of else most
        self._times: deque[int] = deque()
        self._is_over = False

    @property
    @override
    def is_settled(self) -> bool:
        if self._is_over:
            return True
        return self.value is not None and self.value[0] == (-math.inf if self._all_of else math.inf)

    @override
    def step(self, now_ns: int) -> None:
        samples = self._operand.step(now_ns)
        if self._is_everything:
            self._take(samples)
            return
        self._times.append(now_ns)
        self._take(self._inside(samples))

    def _inside(self, samples: Iterable[Sample]) -> list[Sample]:
        found = []
        for sample in samples:
            then_ns = self._times.popleft()
            if self._end is not None and then_ns > self._end:
                self._is_over = True
            elif then_ns >= self._start:
                found.append(sample)
            if self._end is not None and then_ns >= self._end:
                self._is_over = True
        return found

    def _take(self, samples: Iterable[Sample]) -> None:
        value = self.value
        for sample in samples:
            if sample is None:
                continue
            value = sample if value is None else self._pick(value, sample)
        self.value = value
        if self.decided is None and value is not None:
            if value[1] is not self._all_of:
                self.decided = value[1]
            elif self._is_over:
                self.decided = self._all_of

    @override
    def finish(self, hope: Hope) -> Sample:
        rest = self._operand.finish(hope)
        self._take(rest if self._is_everything else self._inside(rest))
        if hope is Hope.WORST and self._all_of and self.decided is None:
            return fails(0)
        if self._all_of or self.decided is not None:
            return self.value
        # A window without an end ends with the mission, whatever the robot does then.
        is_settled = self._end is None or self._operand.is_settled_by_end
        if not self._is_over and hope.reaches(is_settled_by_end=is_settled):
            return holds(0)
        if self.value is None and self._end is not None and not self._is_over:
            return fails(0)
        return self.value


class Up(Root):
    """`left until right` from the start on, or its dual."""

    def __init__(
        self, left: Future, right: Future, start_ns: int, end_ns: int | None, *, dual: bool
    ) -> None:
        self._aligned = Aligned((left, right))
        self._start, self._end = start_ns, end_ns
        self._dual = dual
        self._inner, self._outer = (most, least) if dual else (least, most)
        self._kept = fails(0) if dual else holds(0)
        self._is_empty = True
        self._times: deque[int] = deque()
        self._is_over = False
        self._is_settled_by_end = left.is_settled_by_end and right.is_settled_by_end

    @override
    def step(self, now_ns: int) -> None:
        self._times.append(now_ns)
        self._take(self._aligned.step(now_ns))

    def _take(self, pairs: Iterable[tuple[Sample, ...]]) -> None:
        for left, right in pairs:
            now_ns = self._times.popleft()
            if self._end is not None and now_ns > self._end:
                self._is_over = True
            if self._is_over:
                continue
            self._is_empty = self._is_empty and now_ns < self._start
            if now_ns >= self._start and right is not None:
                reached = self._inner(self._kept, right)
                self.value = reached if self.value is None else self._outer(self.value, reached)
            if left is not None:
                self._kept = self._inner(self._kept, left)
            self._is_over = self._end == now_ns
        if self.decided is None:
            if self.value is not None and self.value[1] is not self._dual:
                self.decided = not self._dual
            elif self._is_over or self._kept[1] is self._dual:
                has_value = self.value is not None or self._is_empty
                self.decided = self._dual if has_value else None

    @override
    def finish(self, hope: Hope) -> Sample:
        self._take(self._aligned.finish(hope))
        is_settled = self._end is None or self._is_settled_by_end
        if self.decided is None and not self._dual and hope.reaches(is_settled_by_end=is_settled):
            return holds(0)
        if self.decided is None and self._dual and hope is Hope.WORST:
            return fails(0)
        if self._is_empty:
            return holds(0) if self._dual else fails(0)
        return self.value


class RootJoint(Root):
    """`and` or `or` of formulas at the start."""

    def __init__(self, parts: Sequence[Root], *, all_of: bool) -> None:
        self._parts = parts
        self._all_of = all_of

    @override
    def step(self, now_ns: int) -> None:
        for part in self._parts:
            part.step(now_ns)
        self.value = joined([part.value for part in self._parts], all_of=self._all_of)
        verdicts = [part.decided for part in self._parts]
        if any(one is not None and one is not self._all_of for one in verdicts):
            self.decided = not self._all_of
        elif None not in verdicts:
            self.decided = self._all_of

    @override
    def finish(self, hope: Hope) -> Sample:
        return joined([part.finish(hope) for part in self._parts], all_of=self._all_of)
