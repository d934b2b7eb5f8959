"""A formula at the start of a run: its verdict so far, and in the end."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterable, Sequence

from typing_extensions import override

from bt_mission.requirements.looking_ahead import Aligned, Future, Present, cut_off
from bt_mission.requirements.looking_back import Atom, Extreme, Past
from bt_mission.requirements.samples import (
    Hope,
    Sample,
    fails,
    holds,
    joined,
    least,
    most,
)


class Root(ABC):
    """A formula at the instant of the start.

    Attributes:
        value: Its value by what was seen so far.
        decided: Whether it holds, where nothing that comes can change that.
    """

    value: Sample = None
    decided: bool | None = None

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
        if self._all_of or self.decided is not None:
            return self.value
        # A window without an end ends with the mission, whatever the robot does then.
        is_settled = self._end is None or self._operand.is_settled_by_end
        if not self._is_over and hope.reaches(is_settled_by_end=is_settled):
            return holds(0)
        if self.value is None and self._end is not None and not self._is_over:
            return fails(0)
        return self.value


class Sparing(Throughout):
    """One of some parts at every instant of a window; those that are not worse are spared.

    A comparison that is not worse than the worst so far spares the others, unless they remember.
    """

    def __init__(self, parts: Sequence[Past], start_ns: int, end_ns: int | None) -> None:
        super().__init__(Present(parts[0]), start_ns, end_ns, all_of=True)
        self._parts = parts
        self._guards = [part for part in parts if isinstance(part, Atom)]
        self._remembering = [part for part in parts if part.remembers]
        self._is_any_strict = any(guard.is_strict for guard in self._guards)
        self._worst = math.nan

    def _is_spared(self, now_ns: int) -> bool:
        """Tell that an instant is not worse; the parts that remember have seen it then."""
        worst = self._worst
        for guard in self._guards:
            margin = guard.at_least()
            if margin is not None and margin >= worst:
                for part in self._remembering:
                    part.at(now_ns)
                return True
        return False

    def _value_at(self, now_ns: int) -> Sample:
        if len(self._parts) == 1:
            return self._parts[0].at(now_ns)
        return joined([part.at(now_ns) for part in self._parts], all_of=False)

    @override
    def _take(self, samples: Iterable[Sample]) -> None:
        super()._take(samples)
        if self.value is not None:
            margin, holds_by_it = self.value[:2]
            is_telling = margin != 0 or not (holds_by_it and self._is_any_strict)
            self._worst = margin if is_telling else math.ulp(0.0)


class Kept(Sparing):
    """What looks back, at every instant of a window from the start on."""

    def __init__(self, operand: Past, start_ns: int, end_ns: int | None) -> None:
        super().__init__(operand.alternatives, start_ns, end_ns)
        self._last = math.inf if end_ns is None else end_ns

    @override
    def step(self, now_ns: int) -> None:
        if self._is_over or (now_ns < self._last and self._is_spared(now_ns)):
            return
        sample = self._value_at(now_ns)
        self._is_over = now_ns >= self._last
        self._take((sample,) if self._start <= now_ns <= self._last else ())

    @override
    def _inside(self, samples: Iterable[Sample]) -> list[Sample]:
        return []


class Steady(Root):
    """One comparison at every instant (`all_of`), or at some: the most frequent formula."""

    def __init__(self, atom: Atom, *, all_of: bool) -> None:
        self._atom = atom
        self._all_of = all_of
        self._extreme = math.nan

    @override
    def step(self, now_ns: int) -> None:
        if self._all_of:
            margin = self._atom.at_least()
            if margin is not None and margin >= self._extreme:
                return
        margin = self._atom.margin()
        if margin is None:
            return
        extreme = self._extreme
        if self.value is None or (margin < extreme if self._all_of else margin > extreme):
            self._extreme = margin
            self.value = value = self._atom.valued(margin, now_ns)
            if value[1] is not self._all_of:
                self.decided = value[1]

    @override
    def finish(self, hope: Hope) -> Sample:
        is_open = not self._all_of and self.decided is None
        return holds(0) if is_open and hope is Hope.ANYTHING else self.value


class Answered(Sparing):
    """At every instant from the start on: one of some parts, or an answer within a window.

    Only those instants are waited for that might be worse than all before them.
    """

    def __init__(self, parts: Sequence[Past], answer: Past, window: tuple[int, int]) -> None:
        super().__init__(parts, 0, None)
        self._answer = answer
        self._from, self._to = window
        self._best = Extreme(all_of=False)
        self._waiting: deque[tuple[int, Sample]] = deque()

    @override
    def step(self, now_ns: int) -> None:
        waiting = self._waiting
        if not self._is_spared(now_ns):
            waiting.append((now_ns, self._value_at(now_ns)))
        if waiting:
            self._settle(now_ns - 1)
            self._best.add(now_ns, self._answer.at(now_ns))
            self._settle(now_ns)
        elif self._answer.remembers:
            self._answer.at(now_ns)

    def _settle(self, now_ns: int) -> None:
        """Settle the instants whose windows have ended by now."""
        waiting = self._waiting
        while waiting and waiting[0][0] + self._to <= now_ns:
            then_ns, sample = waiting.popleft()
            answer = self._best.pick(then_ns + self._from)
            self._take((joined((sample, answer), all_of=False),))

    @override
    def finish(self, hope: Hope) -> Sample:
        for then_ns, sample in self._waiting:
            found = self._best.pick(then_ns + self._from)
            is_settled = self._answer.is_settled_by_end
            answer = cut_off(found, then_ns, hope, is_settled_by_end=is_settled)
            self._take((joined((sample, answer), all_of=False),))
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
                self.decided = self._dual

    @override
    def finish(self, hope: Hope) -> Sample:
        self._take(self._aligned.finish(hope))
        is_settled = self._end is None or self._is_settled_by_end
        if self.decided is None and not self._dual and hope.reaches(is_settled_by_end=is_settled):
            return holds(0)
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
