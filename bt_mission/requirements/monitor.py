"""Monitors of requirements and of conditions while a mission runs."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence
from typing import Protocol

from bt_mission.base.stamps import NS
from bt_mission.base.verdicts import VACUOUS, RequirementResult, Verdict
from bt_mission.language.expressions.syntax import SyntaxNode
from bt_mission.language.mission import Requirement
from bt_mission.requirements.compiler import Compiler, Number, Reader
from bt_mission.requirements.language.formula import (
    Condition,
    full_after,
    root_of,
    signals_in,
    vacuous_verdict,
)
from bt_mission.requirements.language.premises import Premise, premises_of
from bt_mission.requirements.language.syntax import SignalValue
from bt_mission.requirements.roots import Root
from bt_mission.requirements.samples import Sample, Truncation


class SignalSource(Protocol):
    """Where the values of signals come from."""

    def reader(self, signal: SignalValue, /) -> Reader | str:
        """Return what gives a signal's present value, or why it is not known here."""

    def lower_bound(self, signal: SignalValue, /) -> Number | None:
        """Return what gives a lower bound of a signal, if that costs less than its value."""

    def measured_by(self, signal: SignalValue, /) -> str:
        """Return what measures a signal in place of the truth; empty for the truth."""


class Monitor:
    """Evaluates one requirement, one instant after another, with bounded memory.

    Args:
        source: Gives its signals.
    """

    def __init__(self, requirement: Requirement, source: SignalSource) -> None:
        self.requirement = requirement
        self.violated_ns: int | None = None
        self._last_ns = 0
        self._end: tuple[Verdict, Sample] | None = None
        self._compiler, self._missing = _compiler(root_of(requirement), source)
        signals = {signal.key: signal for signal in signals_in(root_of(requirement))}
        self._sources = tuple(
            f"{key} by {by}"
            for key, signal in signals.items()
            if (by := source.measured_by(signal))
        )
        self.root: Root | None = None
        """The first of its operators; None where a signal is missing."""
        self.premises: tuple[tuple[Premise, Root], ...] = ()
        """Those that have not come true."""
        if not self._missing:
            self.root = self._compiler.root(root_of(requirement))
            compiler = Compiler(self._compiler.readers)
            self.premises = tuple(
                [(each, compiler.root(each.root)) for each in premises_of(root_of(requirement))]
            )

    def step(self, since_start_ns: int) -> bool:
        """Take the next instant; return whether it is violated since this instant."""
        root = self.root
        if root is None or self._end is not None:
            return False
        self._last_ns = since_start_ns
        root.step(since_start_ns)
        if self.premises:
            self._step_premises(since_start_ns)
        if root.decided is not False or self.violated_ns is not None:
            return False
        self.violated_ns = since_start_ns
        return True

    def _step_premises(self, since_start_ns: int) -> None:
        for _, root in self.premises:
            root.step(since_start_ns)
        if any(root.decided is True for _, root in self.premises):
            self.premises = tuple([pair for pair in self.premises if pair[1].decided is not True])

    @property
    def unmet(self) -> tuple[Premise, ...]:
        """The premises that have not come true."""
        return tuple([premise for premise, _ in self.premises])

    @property
    def now(self) -> Sample:
        """The value over the run so far."""
        return None if self.root is None else self.root.value

    def value_of_instant(self) -> Sample:
        """Return the value of the present instant alone, as if it were the whole run."""
        if self.root is None:
            return None
        root = Compiler(self._compiler.readers).root(root_of(self.requirement))
        root.step(0)
        return root.value

    def finish(self, *, is_complete: bool = True) -> bool:
        """End the run; return whether the requirement is violated by its end alone.

        Args:
            is_complete: Has the mission ended, rather than been cut? After a run that was cut,
                anything could have followed.
        """
        if self.root is None or self._end is not None:
            return False
        values = [root.finish(Truncation.NEUTRAL) for _, root in self.premises]
        pairs = zip(self.premises, values, strict=True)
        self.premises = tuple([pair for pair, value in pairs if value is None or not value[1]])
        self._end = end = self._at_end(is_complete=is_complete)
        return end[0] == "violated" and self.violated_ns is None

    def _at_end(self, *, is_complete: bool) -> tuple[Verdict, Sample]:
        best = self._over(Truncation.WEAK_AFTER_MISSION if is_complete else Truncation.WEAK)
        value = self._over(Truncation.NEUTRAL)
        worst = self._over(Truncation.STRONG_AFTER_MISSION if is_complete else Truncation.STRONG)
        if self.violated_ns is not None:
            return "violated", best
        if self.root is not None and self.root.decided is True:
            return "holds", value
        if value is None or best is None:
            if any(premise.is_window for premise in self.unmet):
                return "holds", None  # nothing fell into its windows
            return "open" if self._never_full else "unknown", None
        if not best[1]:
            return "violated", best
        if not value[1]:
            return "open", best
        return "holds" if worst is not None and worst[1] else "open", value

    def _over(self, truncation: Truncation) -> Sample:
        """Return the value of the run, if it ended here."""
        return copy.deepcopy(self.root).finish(truncation) if self.root else None

    @property
    def _never_full(self) -> bool:
        """Did the run end before its windows that look back were full?"""
        return self._last_ns < round(full_after(root_of(self.requirement)) * NS)

    @property
    def result(self) -> RequirementResult:
        """The verdict over the run so far, or at its end."""
        verdict, value = self._end or self._so_far
        if verdict == "holds" and self.premises:
            verdict = self._without_premise
        has_measure = value is not None and math.isfinite(value[0])
        return RequirementResult(
            name=self.requirement.name,
            requirement=self.requirement.text,
            verdict=verdict,
            margin=_rounded(value[0]) if value is not None and has_measure else None,
            unit=self._compiler.units[value[3]] if value is not None and has_measure else "",
            at=value[2] / NS if value is not None and (has_measure or value[1]) else None,
            violated_at=None if self.violated_ns is None else self.violated_ns / NS,
            on_violation=self.requirement.on_violation,
            why=self._why(verdict),
            sources=self._sources,
            unmet=tuple(premise.why_not for premise in self.unmet),
        )

    @property
    def _without_premise(self) -> Verdict:
        """The verdict where nothing is violated, and a premise has not come true."""
        can_come = self._end is None and any(root.decided is None for _, root in self.premises)
        if can_come:
            return "open"
        return vacuous_verdict(self.requirement)

    @property
    def _so_far(self) -> tuple[Verdict, Sample]:
        if self.root is None:
            return "unknown", None
        decided: dict[bool | None, Verdict] = {True: "holds", False: "violated", None: "open"}
        return decided[self.root.decided], self.root.value

    def _why(self, verdict: Verdict) -> str:
        if verdict == "unknown":
            problem = "; ".join(self._compiler.problems)
            return self._missing or problem or "its signals never had a value"
        if verdict in VACUOUS:
            return self.unmet[0].why_not
        if verdict == "open" and self._end is not None:
            if self._end[1] is None:
                full_s = full_after(root_of(self.requirement))
                return f"the run ended before its window that looks back was full, at {full_s:g} s"
            return "the run ended before it could be decided"
        return ""


class ConditionMonitor:
    """Evaluates a condition at one control step after another.

    Args:
        source: Gives its signals.
        held_ns: How long it has to be true without a break.

    Attributes:
        why_unknown: Why it cannot be evaluated here; empty where it can.
    """

    def __init__(self, condition: Condition, source: SignalSource, held_ns: int = 0) -> None:
        self._held_ns = held_ns
        self._since_ns: int | None = None
        compiler, self.why_unknown = _compiler(condition.root, source)
        self._formula = None if self.why_unknown else compiler.formula(condition.root)

    def step(self, since_start_ns: int) -> bool:
        """Take the next instant; return whether the condition has been true for long enough."""
        value = None if self._formula is None else self._formula.at(since_start_ns)
        if value is None or not value[1]:
            self._since_ns = None
            return False
        if self._since_ns is None:
            self._since_ns = since_start_ns
        return since_start_ns - self._since_ns >= self._held_ns


def _compiler(root: SyntaxNode, source: SignalSource) -> tuple[Compiler, str]:
    """Return a compiler with the signals of a formula, and which of them are missing, and why."""
    compiler, missing = Compiler({}), {}
    for signal in signals_in(root):
        reader, bound = source.reader(signal), source.lower_bound(signal)
        if isinstance(reader, str):
            missing[signal.key] = reader
        else:
            compiler.readers[signal.key] = reader
        if bound is not None:
            compiler.bounds[signal.key] = bound
    return compiler, "; ".join(f"{key}: {why}" for key, why in missing.items())


def _rounded(margin: float) -> float:
    """Return a margin without the noise of the last digits, and 0 where it holds by no more."""
    if abs(margin) <= math.ulp(0.0):
        return 0.0
    return float(f"{margin:.9g}") + 0.0


class Monitors:
    """The monitors of a run's requirements.

    Args:
        requirements: In the order in which they are reported.
        source: Gives their signals.
        on_violation: Called once for each that is violated.
    """

    def __init__(
        self,
        requirements: Sequence[Requirement],
        source: SignalSource,
        on_violation: Callable[[Requirement, RequirementResult], None] = lambda *_: None,
    ) -> None:
        self.monitors = tuple(Monitor(requirement, source) for requirement in requirements)
        self._on_violation = on_violation

    def step(self, since_start_ns: int) -> None:
        """Take the next instant; all see the same one, whatever is done about a violation."""
        self._report([monitor for monitor in self.monitors if monitor.step(since_start_ns)])

    def finish(self, *, is_complete: bool = True) -> None:
        """End the run, and report what is violated by its end alone."""
        self._report(
            [monitor for monitor in self.monitors if monitor.finish(is_complete=is_complete)]
        )

    def _report(self, violated: Sequence[Monitor]) -> None:
        for monitor in violated:
            self._on_violation(monitor.requirement, monitor.result)

    @property
    def results(self) -> tuple[RequirementResult, ...]:
        """The verdict of each."""
        return tuple(monitor.result for monitor in self.monitors)
