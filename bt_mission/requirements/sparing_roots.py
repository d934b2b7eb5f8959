"""Formulas at the start of a run that need not look at every instant as a whole."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence

from typing_extensions import override

from bt_mission.requirements.looking_ahead import Present, cut_off
from bt_mission.requirements.looking_back import Atom, Extreme, Past
from bt_mission.requirements.roots import NEVER, Throughout
from bt_mission.requirements.samples import Hope, Sample, fails, joined


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
        if self._guards and not self._remembering:
            self.guard = self._guards[0]

    @property
    @override
    def is_settled(self) -> bool:
        if super().is_settled:
            return True
        is_best = self.value is not None and self.value[0] == math.inf
        return is_best and self._end is None and any(part.is_highest for part in self._parts)

    @override
    def is_spared_now(self) -> bool:
        margin = None if self.guard is None else self.guard.margin()
        return margin is not None and margin >= self._worst

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
        self._last = self.due_ns = NEVER if end_ns is None else end_ns

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


class Steady(Throughout):
    """One comparison at every instant of a window (`all_of`), or at some: the most frequent one."""

    def __init__(self, atom: Atom, start_ns: int, end_ns: int | None, *, all_of: bool) -> None:
        super().__init__(Present(atom), start_ns, end_ns, all_of=all_of)
        self._atom = self.guard = atom
        self._last = self.due_ns = NEVER if end_ns is None else end_ns
        self._extreme = math.nan
        self.is_spared_above = all_of

    @property
    def is_from_start(self) -> bool:
        """Does its window begin with the run?"""
        return self._start == 0

    @override
    def is_spared_now(self) -> bool:
        return self.value is not None  # which is from the present instant, or not worse

    @override
    def step(self, now_ns: int) -> None:
        if self._start <= now_ns <= self._last and not self._is_over:
            self._compare(now_ns)
        if now_ns >= self._last:
            self._is_over = True
            if self.decided is None and self.value is not None:
                self.decided = self._all_of

    def _compare(self, now_ns: int) -> None:
        if self._all_of:
            margin = self._atom.at_least()
            if margin is not None and margin >= self._extreme:
                return
        margin = self._atom.margin()
        if margin is not None:
            self.take(margin, now_ns)

    def take(self, margin: float, now_ns: int) -> None:
        """Take the margin of an instant that is in the window, and before its end."""
        extreme = self._extreme
        if self.value is None or (margin < extreme if self._all_of else margin > extreme):
            self._extreme = margin
            self.value = value = self._atom.valued(margin, now_ns)
            if value[1] is not self._all_of:
                self.decided = value[1]


class Answered(Sparing):
    """At every instant from the start on: one of some parts, or an answer within a window.

    Only those instants are waited for that might be worse than all before them.
    """

    def __init__(self, parts: Sequence[Past], answer: Past, window: tuple[int, int]) -> None:
        super().__init__(parts, 0, None)
        self._answer = answer
        if answer.remembers:
            self.guard = None
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
            self.due_ns = 0 if waiting else NEVER
        elif self._answer.remembers:
            self._answer.at(now_ns)

    @property
    @override
    def is_settled(self) -> bool:
        return not self._waiting and super().is_settled

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
        return fails(0) if hope is Hope.WORST and self.decided is None else self.value
