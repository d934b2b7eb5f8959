"""A formula at the start of a run: its verdict so far, and at the end."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterable, Sequence

from typing_extensions import override

from bt_mission.requirements.operators import (
    ALL_TIME,
    Ahead,
    Aligned,
    Atom,
    CompiledFormula,
    Window,
)
from bt_mission.requirements.samples import (
    Sample,
    Truncation,
    false_at,
    joined,
    least,
    most,
    true_at,
)


class Root(ABC):
    """A formula at the instant of the start.

    Attributes:
        value: Its value over the run so far.
        decided: Whether it is true, once no later instant can change that.
    """

    value: Sample = None
    decided: bool | None = None

    @abstractmethod
    def step(self, now_ns: int) -> None:
        """Take the next instant."""

    @abstractmethod
    def finish(self, truncation: Truncation) -> Sample:
        """Return the value over the whole run, with windows cut off at its end."""


class Throughout(Root):
    """True at every instant of a window from the start on (`all_of`), or at some."""

    def __init__(self, operand: CompiledFormula, window: Window, *, all_of: bool) -> None:
        self._operand = operand
        self._start, self._end = window
        self._all_of = all_of
        self._pick = least if all_of else most
        self._times: deque[int] = deque()
        self._is_over = False
        self._lower_bound = None
        if isinstance(operand, Atom) and all_of and window == ALL_TIME:
            self._lower_bound = operand.lower_bound

    @override
    def step(self, now_ns: int) -> None:
        if self._lower_bound is not None and self.value is not None:
            bound = self._lower_bound()
            if bound is not None and bound >= self.value[0]:
                return
        if not self._operand.looks_ahead:
            self._take(now_ns, self._operand.at(now_ns))
            return
        self._times.append(now_ns)
        for sample in self._operand.step(now_ns):
            self._take(self._times.popleft(), sample)

    def _take(self, then_ns: int, sample: Sample) -> None:
        if sample is not None and self._start <= then_ns <= self._end:
            self.value = value = sample if self.value is None else self._pick(self.value, sample)
            if value[1] is not self._all_of:
                self.decided = value[1]
        if then_ns >= self._end:
            self._is_over = True
            if self.decided is None and self.value is not None:
                self.decided = self._all_of

    @override
    def finish(self, truncation: Truncation) -> Sample:
        for sample in self._operand.finish(truncation):
            self._take(self._times.popleft(), sample)
        # A window without an end ends with the mission, whatever the robot does then.
        is_settled = self._end == math.inf or self._operand.is_settled_by_end
        is_refuted = self._all_of and truncation.refutes(is_settled_by_end=is_settled)
        if is_refuted and self.decided is None:
            return false_at(0)
        if self._all_of or self.decided is not None or self._is_over:
            return self.value
        if truncation.fulfils(is_settled_by_end=is_settled):
            return true_at(0)
        return false_at(0) if self.value is None and self._end < math.inf else self.value


class Lasting(Throughout):
    """`always (before or always[a,b] answer)`, turned into a formula that looks back.

    Args:
        turned: `historically[a,b] before or answer`.
        end_ns: The end of the window, ns.
        is_settled_by_end: Does the answer not change once the mission has ended?
    """

    def __init__(
        self,
        turned: CompiledFormula,
        before: CompiledFormula,
        end_ns: float,
        *,
        is_settled_by_end: bool,
    ) -> None:
        super().__init__(turned, ALL_TIME, all_of=True)
        self._before, self._until_ns = before, end_ns
        self._is_settled_by_end = is_settled_by_end
        self._now_ns, self._full_ns = 0, -math.inf
        """The present instant, and the end of the last window that was asked for."""

    @override
    def step(self, now_ns: int) -> None:
        super().step(now_ns)
        self._now_ns = now_ns
        before = self._before.at(now_ns)
        if before is not None and not before[1]:
            self._full_ns = now_ns + self._until_ns

    @override
    def finish(self, truncation: Truncation) -> Sample:
        is_refuted = truncation.refutes(is_settled_by_end=self._is_settled_by_end)
        if is_refuted and self._full_ns > self._now_ns and self.decided is None:
            return false_at(0)
        return super().finish(truncation)


class Response(Root):
    """`always (before or eventually[a,b] answer)`, as `whenever ... within` gives it.

    An instant at which `before` is no worse than the value so far cannot change that, so its
    answer is not waited for.
    """

    def __init__(self, before: CompiledFormula, answer: Ahead) -> None:
        self._before, self._answer = before, answer
        self._waiting: deque[Sample] = deque()

    @override
    def step(self, now_ns: int) -> None:
        value, before = self.value, self._before.at(now_ns)
        is_wanted = value is None or before is None or least(value, before) is before
        if is_wanted:
            self._waiting.append(before)
        if self._waiting or self._answer.has_memory:
            self._take(self._answer.step(now_ns, is_wanted=is_wanted))

    def _take(self, answers: Iterable[Sample]) -> None:
        for answer in answers:
            sample = joined((self._waiting.popleft(), answer), all_of=False)
            if sample is not None:
                self.value = sample if self.value is None else least(self.value, sample)
                self.decided = None if self.value[1] else False

    @override
    def finish(self, truncation: Truncation) -> Sample:
        self._take(self._answer.finish(truncation))
        is_open = truncation is Truncation.STRONG and self.decided is None
        return false_at(0) if is_open else self.value


class UntilRoot(Root):
    """`left until right` from the start on, or with `all_of` its dual."""

    def __init__(self, parts: Sequence[CompiledFormula], window: Window, *, all_of: bool) -> None:
        self._aligned = Aligned(parts)
        self._start, self._end = window
        self._all_of = all_of
        self._inner, self._outer = (most, least) if all_of else (least, most)
        self._kept = false_at(0) if all_of else true_at(0)
        self._is_empty = True
        self._is_over = False
        is_settled = all(part.is_settled_by_end for part in parts)
        self._is_settled_by_end = is_settled or self._end == math.inf

    @override
    def step(self, now_ns: int) -> None:
        self._take(self._aligned.step(now_ns))

    def _take(self, instants: Iterable[tuple[int, tuple[Sample, ...]]]) -> None:
        for now_ns, (left, right) in instants:
            self._is_over = self._is_over or now_ns > self._end
            if self._is_over:
                continue
            self._is_empty = self._is_empty and now_ns < self._start
            if now_ns >= self._start and right is not None:
                reached = self._inner(self._kept, right)
                self.value = reached if self.value is None else self._outer(self.value, reached)
            if left is not None:
                self._kept = self._inner(self._kept, left)
            self._is_over = now_ns == self._end
        if self.decided is None:
            if self.value is not None and self.value[1] is not self._all_of:
                self.decided = not self._all_of
            elif self._is_over or self._kept[1] is self._all_of:
                has_value = self.value is not None or self._is_empty
                self.decided = self._all_of if has_value else None

    @override
    def finish(self, truncation: Truncation) -> Sample:
        self._take(self._aligned.finish(truncation))
        is_refuted = truncation.refutes(is_settled_by_end=self._is_settled_by_end)
        if self.decided is None and self._all_of and is_refuted:
            return false_at(0)
        fulfils = truncation.fulfils(is_settled_by_end=self._is_settled_by_end)
        if self.decided is None and not self._all_of and fulfils:
            return true_at(0)
        if self._is_empty:
            return true_at(0) if self._all_of else false_at(0)
        return self.value


class JointRoot(Root):
    """`and` (`all_of`) or `or` of formulas at the start."""

    def __init__(self, parts: Sequence[Root], *, all_of: bool) -> None:
        self._parts = parts
        self._all_of = all_of

    @override
    def step(self, now_ns: int) -> None:
        for part in self._parts:
            part.step(now_ns)
        self.value = joined([part.value for part in self._parts], all_of=self._all_of)
        verdicts = [part.decided for part in self._parts]
        if (not self._all_of) in verdicts:
            self.decided = not self._all_of
        elif None not in verdicts:
            self.decided = self._all_of

    @override
    def finish(self, truncation: Truncation) -> Sample:
        return joined([part.finish(truncation) for part in self._parts], all_of=self._all_of)
