"""Watches requirements while a mission runs: each has a verdict, a margin and an instant."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol, TypeAlias, runtime_checkable

from bt_mission.core.stamps import NS
from bt_mission.core.text import seconds
from bt_mission.core.units import shown_unit
from bt_mission.language.requirements.formula import (
    OnViolation,
    Requirement,
    full_after,
    signals_in,
)
from bt_mission.language.requirements.syntax import SignalValue
from bt_mission.requirements.comparisons import Reader
from bt_mission.requirements.compiler import Compiler
from bt_mission.requirements.roots import Root
from bt_mission.requirements.samples import Hope, Sample
from bt_mission.requirements.watched_roots import WatchedRoots

Verdict: TypeAlias = Literal["holds", "violated", "open", "unknown"]


class SignalSource(Protocol):
    """Where the values of signals come from."""

    def reader(self, signal: SignalValue, /) -> Reader | str:
        """Return what gives a signal's present value, or why it is not known here."""

    def at_least(self, signal: SignalValue, /) -> Callable[[], float | None] | None:
        """Return what gives a lower bound of a signal, if that costs less than its value."""


@runtime_checkable
class NamedSources(Protocol):
    """A source that has some signals from elsewhere than their names say."""

    def measured_by(self, signal: SignalValue, /) -> str:
        """Return what measures a signal in the place of the truth; empty for the truth."""


@dataclass(frozen=True)
class RequirementResult:
    """What a requirement came to.

    Attributes:
        verdict: ``open`` where the run was over, or cut, before it could be decided; ``unknown``
            where a signal is not known or never had a value.
        margin: By how much it holds; below 0 by how much it is violated. None where it has no
            measure.
        unit: Of the margin.
        at: The instant that decides the margin, s since the start.
        violated_at: When the violation was noticed, s since the start.
        why: Why it is open or unknown.
        sources: Signals that are measured where a simulation would know the truth, such as
            ``speed by odometry``.
    """

    name: str
    requirement: str
    verdict: Verdict
    margin: float | None = None
    unit: str = ""
    at: float | None = None
    violated_at: float | None = None
    on_violation: OnViolation = "report"
    why: str = ""
    sources: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.name}: {self.outcome}"

    @property
    def outcome(self) -> str:
        """Verdict, margin, instant and reason in words."""
        has_measure = self.margin is not None and self.verdict in ("holds", "violated")
        measure = (
            "" if not has_measure else f" by {abs(self.margin or 0.0):.4g} {self.unit}".rstrip()
        )
        when = "" if self.at is None else f" at {seconds(self.at)}"
        why = f": {self.why}" if self.why else ""
        sources = f" ({', '.join(self.sources)})" if self.sources else ""
        return f"{self.verdict}{measure}{when}{sources}{why}"


class Monitor:
    """Evaluates one requirement, one instant after another, with bounded memory.

    Args:
        source: Gives its signals.
    """

    def __init__(self, requirement: Requirement, source: SignalSource) -> None:
        self.requirement = requirement
        self.violated_ns: int | None = None
        self.is_told = False
        """Was it said that it is violated?"""
        self._last_ns = 0
        self._end: tuple[Verdict, Sample] | None = None
        readers: dict[str, Reader] = {}
        bounds: dict[str, Callable[[], float | None]] = {}
        missing: dict[str, str] = {}
        measured: dict[str, str] = {}
        for signal in signals_in(requirement.root):
            found = source.reader(signal)
            if isinstance(found, str):
                missing[signal.key] = found
            else:
                readers[signal.key] = found
            bound = source.at_least(signal)
            if bound is not None:
                bounds[signal.key] = bound
            if isinstance(source, NamedSources) and (by := source.measured_by(signal)):
                measured[signal.key] = f"{signal.key} by {by}"
        self._sources = tuple(measured.values())
        self._missing = "; ".join(f"{key}: {why}" for key, why in missing.items())
        self._compiler = Compiler(readers, bounds)
        self._root: Root | None = None if missing else self._compiler.root(requirement.root)

    @property
    def root(self) -> Root | None:
        """The formula, while it is evaluated."""
        return None if self._end is not None else self._root

    def step(self, since_start_ns: int) -> None:
        """Take the next instant."""
        root = self.root
        self._last_ns = since_start_ns
        if root is not None:
            root.step(since_start_ns)
            if root.decided is False and self.violated_ns is None:
                self.violated_ns = since_start_ns

    @property
    def now(self) -> Sample:
        """The value by what was seen so far."""
        return None if self._root is None else self._root.value

    def value_of_instant(self) -> Sample:
        """Return the value of the present instant by itself, as if it were the whole run."""
        if self._root is None:
            return None
        root = Compiler(self._compiler.readers).root(self.requirement.root)
        root.step(0)
        return root.value

    def finish(self, *, is_complete: bool = True, last_ns: int | None = None) -> None:
        """End the run.

        Args:
            is_complete: Did the mission come to its own end? After a run that was cut, anything
                could have followed.
            last_ns: The last instant, since the start; None is that of the last step.
        """
        if self._root is None or self._end is not None:
            return
        self._last_ns = self._last_ns if last_ns is None else last_ns
        best = copy.deepcopy(self._root).finish(Hope.ROBOT if is_complete else Hope.ANYTHING)
        least = copy.deepcopy(self._root).finish(Hope.NOTHING)
        if self.violated_ns is not None:
            self._end = ("violated", best)
        elif self._root.decided is True:
            self._end = ("holds", least)
        elif least is None or best is None:
            self._end = ("open" if self._never_full else "unknown", None)
        elif not best[1]:
            self._end = ("violated", best)
        elif not least[1] or not (is_complete or self._holds_at_worst):
            self._end = ("open", best if not least[1] else least)
        else:
            self._end = ("holds", least)

    @property
    def _holds_at_worst(self) -> bool:
        """Does it hold whatever could have followed?"""
        worst = copy.deepcopy(self._root).finish(Hope.WORST) if self._root else None
        return worst is not None and worst[1]

    @property
    def _never_full(self) -> bool:
        """Did the run end before its windows that look back were full?"""
        return self._last_ns < round(full_after(self.requirement.root) * NS)

    @property
    def result(self) -> RequirementResult:
        """What it came to, or what it has come to so far."""
        verdict, value = self._end or self._so_far
        why = self._why(verdict)
        unit = ""
        if value is not None and value[3] >= 0:
            unit = shown_unit(self._compiler.units[value[3]])
        has_measure = value is not None and math.isfinite(value[0])
        return RequirementResult(
            name=self.requirement.name,
            requirement=self.requirement.text,
            verdict=verdict,
            margin=_rounded(value[0]) if value is not None and has_measure else None,
            unit=unit if has_measure else "",
            at=value[2] / NS if value is not None and (has_measure or value[1]) else None,
            violated_at=None if self.violated_ns is None else self.violated_ns / NS,
            on_violation=self.requirement.on_violation,
            why=why,
            sources=self._sources,
        )

    @property
    def _so_far(self) -> tuple[Verdict, Sample]:
        if self._root is None:
            return "unknown", None
        decided: dict[bool | None, Verdict] = {True: "holds", False: "violated", None: "open"}
        return decided[self._root.decided], self._root.value

    def _why(self, verdict: Verdict) -> str:
        if verdict == "unknown":
            problem = "; ".join(self._compiler.problems)
            return self._missing or problem or "its signals never had a value"
        if verdict == "open" and self._end is not None:
            if self._end[1] is None:
                full_s = full_after(self.requirement.root)
                return f"the run ended before its window that looks back was full, at {full_s:g} s"
            return "the run ended before it could be decided"
        return ""


def _rounded(margin: float) -> float:
    """Return a margin without the noise of the last digits, and 0 where it holds by no more."""
    if abs(margin) <= math.ulp(0.0):
        return 0.0
    return float(f"{margin:.9g}") + 0.0


class Monitors:
    """The requirements of a run.

    Args:
        requirements: In the order in which they are told.
        source: Gives their signals.
        on_violation: Called once for each that comes to be violated.
    """

    def __init__(
        self,
        requirements: Sequence[Requirement],
        source: SignalSource,
        on_violation: Callable[[Requirement, RequirementResult], None] = lambda *_: None,
    ) -> None:
        self._monitors = [Monitor(one, source) for one in requirements]
        self._on_violation = on_violation
        self._last_ns = 0
        self._watches = WatchedRoots(
            {n: one.root for n, one in enumerate(self._monitors) if one.root is not None}
        )

    def step(self, since_start_ns: int) -> None:
        """Take the next instant; all see the same, whatever is done about a violation."""
        self._last_ns = since_start_ns
        violated = self._watches.step(since_start_ns)
        for number in violated:
            self._monitors[number].violated_ns = since_start_ns
        for number in violated:
            self._tell(self._monitors[number])

    def finish(self, *, is_complete: bool = True) -> None:
        """End the run; what is violated only by its end is told now."""
        self._watches.clear()
        for monitor in self._monitors:
            monitor.finish(is_complete=is_complete, last_ns=self._last_ns)
            if monitor.result.verdict == "violated":
                self._tell(monitor)

    def _tell(self, monitor: Monitor) -> None:
        if not monitor.is_told:
            monitor.is_told = True
            self._on_violation(monitor.requirement, monitor.result)

    @property
    def monitors(self) -> Sequence[Monitor]:
        """Each requirement by itself, as it is now."""
        self._watches.catch_up()
        return self._monitors

    @property
    def results(self) -> tuple[RequirementResult, ...]:
        """What each came to."""
        return tuple(monitor.result for monitor in self.monitors)
