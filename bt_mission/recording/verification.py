"""Requirements evaluated over a recording, by what evaluates them while a mission runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from operator import itemgetter
from pathlib import Path
from typing import TypeAlias

import numpy as np

from bt_mission.base.stamps import NS
from bt_mission.base.text import seconds
from bt_mission.base.verdicts import RequirementResult
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.language.mission import Requirement
from bt_mission.recording.model import RecordedRequirement, RecordedRun
from bt_mission.recording.reader import RunReader
from bt_mission.recording.reading import RecordedFile, RecordingError
from bt_mission.recording.recorded_messages import (
    TEXT,
    RecordedMessage,
    SignalLine,
    fold,
    recorded_messages,
)
from bt_mission.recording.recorded_signals import RecordedSignals, RecordingSurvey
from bt_mission.recording.replay.timeline import Timeline, TimelineReader
from bt_mission.recording.signal_samples import requirements_in
from bt_mission.requirements.checks import RequirementNames
from bt_mission.requirements.language.formula import CONTROL_STEP_S, root_of, walk
from bt_mission.requirements.language.syntax import EVERYTHING, Measure, Temporal
from bt_mission.requirements.monitor import Monitor, Monitors

PERIOD_NS = round(CONTROL_STEP_S * NS)
"""Between two instants of evaluation, if the recording lacks those of the run."""
MOST_INSTANTS = 2_000_000
"""More than a day."""

OnInstant: TypeAlias = Callable[[float, Sequence[Monitor]], None]
"""Called at each instant, after it was evaluated, with the time since the start, s."""


@dataclass(frozen=True)
class Verification:
    """The results of requirements over a recording.

    Attributes:
        results: The result of each.
        notes: Notes on the source of signals.
        why_cut: Why the end of the run is missing; empty if it is there.
        lacks: What else is missing; empty if nothing is.
    """

    results: tuple[RequirementResult, ...]
    notes: tuple[str, ...]
    why_cut: str
    lacks: str


class RecordedRequirements:
    """A recording whose requirements can be evaluated.

    Args:
        path: The file.
        namespace: The robot's namespace; None is that of the recording.
        robot: The robot of several with missions; None is the first.
        survey: The content of the file, if it is known.

    Raises:
        RecordingError: The file is invalid, cannot be opened, or has no message.
    """

    def __init__(
        self,
        path: Path,
        namespace: str | None = None,
        robot: str | None = None,
        *,
        survey: RecordingSurvey | None = None,
    ) -> None:
        self.survey = survey or RecordingSurvey.of(RecordedFile(path, robot))
        self._robot = robot
        self._namespace = namespace

    @property
    def is_of_mission(self) -> bool:
        """Whether it has a run of a mission."""
        return self.survey.tree is not None

    @property
    def mission(self) -> str:
        """The name of the mission; empty without one."""
        return "" if self.survey.tree is None else self.survey.tree.mission

    @property
    def duration_s(self) -> float:
        """From the start of the mission, or else of the recording, to its end, s."""
        return max(0, self.survey.file.last_ns - self.survey.start_ns) / NS

    @property
    def names(self) -> RequirementNames:
        """The names that requirements can use; any where no mission was recorded."""
        if not self.is_of_mission:
            return RequirementNames()
        nodes = self.survey.nodes
        goals = {node.name for node in nodes if node.kind == ActionLeaf.__name__}
        return RequirementNames(
            {node.name: node.name in goals for node in nodes},
            {node.path: node.kind == ActionLeaf.__name__ for node in nodes},
        )

    def own(self) -> tuple[Requirement, ...]:
        """Return the requirements of the run.

        Raises:
            RecordingError: A requirement cannot be read by this version.
        """
        return requirements_in(self.survey.file)

    def verify(
        self,
        requirements: Sequence[Requirement],
        on_instant: OnInstant = lambda *_: None,
    ) -> Verification:
        """Evaluate requirements at every control step of the run; without one, periodically.

        Args:
            on_instant: Called at each instant.

        Raises:
            RecordingError: The recording is too long.
        """
        signals = RecordedSignals(self.survey, self._namespace)
        monitors = Monitors(requirements, signals)
        file = RecordedFile(self.survey.file.path, self._robot)
        clock = _Instants(self.survey, signals, monitors, on_instant)
        if self.survey.first_sample is not None or self.survey.is_in_order:
            fold(file, clock.take)
        else:
            fold(file, clock.take, among=_sorted(file, signals))
        clock.finish(file.last_ns)
        why_open = self._why_open(file, signals)
        is_interrupted = signals.mission.ending == "interrupted"
        monitors.finish(is_complete=not why_open and not is_interrupted)
        why_unknown = self._why_unknown(file)
        results = tuple(
            _judged(result, why_unknown or signals.problem_of(requirement), why_open)
            for requirement, result in zip(requirements, monitors.results, strict=True)
        )
        return Verification(results, self._notes, why_open, file.missing)

    def _why_open(self, file: RecordedFile, signals: RecordedSignals) -> str:
        """Return why the end of the run is missing; empty if it is there."""
        if file.why_cut:
            return f"the recording is cut: {file.why_cut}"
        if self.is_of_mission and not signals.mission.ending:
            return "the recording ends before the mission does"
        return ""

    def _why_unknown(self, file: RecordedFile) -> str:
        """Return why nothing can be determined; empty if something can."""
        survey = self.survey
        if TEXT in file.unread:
            return f"the messages of the mission cannot be read: {file.unread[TEXT]}"
        first = survey.first_sample
        if first is not None and first.get("cycle") != 1:
            late_s = (int(first["t"]) - survey.start_ns) / NS
            return f"the recording begins {seconds(late_s)} after the mission"
        return ""

    @property
    def _notes(self) -> tuple[str, ...]:
        if self.survey.first_sample is not None:
            return ()
        every = f"evaluated every {PERIOD_NS / NS:g} s"
        return (f"{every}: the recording does not contain the instants of the run",)


def _sorted(file: RecordedFile, signals: RecordedSignals) -> list[tuple[int, RecordedMessage]]:
    """Return the messages that are of use, in the order of time: other tools write as they like."""
    wanted = [happening for happening in recorded_messages(file) if signals.wants(happening[1])]
    return sorted(wanted, key=itemgetter(0))


class _Instants:
    """Evaluates at the instants of the run, or periodically where they were not recorded."""

    def __init__(
        self,
        survey: RecordingSurvey,
        signals: RecordedSignals,
        monitors: Monitors,
        on_instant: OnInstant,
    ) -> None:
        self._survey, self._signals, self._monitors = survey, signals, monitors
        self._on_instant = on_instant
        self._has_samples = survey.first_sample is not None
        self._next_ns = survey.start_ns
        self._is_over = False
        count = (survey.file.last_ns - survey.start_ns) // PERIOD_NS
        if not self._has_samples and count > MOST_INSTANTS:
            raise RecordingError(
                f"{survey.file.path}: its messages span {count * CONTROL_STEP_S / 86400:,.0f} days;"
                " were they recorded by different clocks?"
            )

    def take(self, time_ns: int, happening: RecordedMessage) -> None:
        """Take a message."""
        if not self._has_samples:
            self._go_on(time_ns - 1)
        elif isinstance(happening, SignalLine) and happening.node == self._survey.node:
            self._signals.sample(happening.fields)
            self._evaluate()
            return
        self._signals.take(time_ns, happening)

    def finish(self, last_ns: int) -> None:
        """Evaluate the last instants."""
        if not self._has_samples:
            self._go_on(last_ns)

    def _go_on(self, until_ns: int) -> None:
        while self._next_ns <= until_ns and not self._is_over:
            self._signals.now_ns = self._next_ns
            self._next_ns += PERIOD_NS
            self._is_over = bool(self._signals.mission.ending)
            self._evaluate()

    def _evaluate(self) -> None:
        since_ns = self._signals.now_ns - self._survey.start_ns
        self._monitors.step(since_ns)
        self._on_instant(since_ns / NS, self._monitors.monitors)
        self._signals.forget()


def _judged(result: RequirementResult, why: str, why_open: str) -> RequirementResult:
    """Return a result that claims no more than the recording shows."""
    if why and result.verdict != "unknown":
        return replace(
            result, verdict="unknown", margin=None, unit="", at=None, violated_at=None, why=why
        )
    if result.verdict == "open" and why_open:
        return replace(result, why=why_open)
    return result


# ---- margins over time ---------------------------------------------------------------------


class _Curves:
    """Keeps the margins of requirements at every instant."""

    def __init__(self, requirements: Sequence[Requirement]) -> None:
        self.is_of_instants = [_speaks_of_instants(requirement) for requirement in requirements]
        self.times: list[float] = []
        self.margins: list[list[float]] = [[] for _ in requirements]

    def take(self, time_s: float, monitors: Sequence[Monitor]) -> None:
        """Take in the margins of an instant."""
        self.times.append(time_s)
        for monitor, alone, margins in zip(
            monitors, self.is_of_instants, self.margins, strict=True
        ):
            value = monitor.value_of_instant() if alone else monitor.now
            margins.append(math.nan if value is None else value[0])


def _speaks_of_instants(requirement: Requirement) -> bool:
    """Return whether a requirement is about each instant alone."""
    root = root_of(requirement)
    return (
        isinstance(root, Temporal)
        and root.window == EVERYTHING
        and not any(isinstance(part, Temporal | Measure) for part in [*walk(root)][1:])
    )


def recorded_requirements(recorded: RecordedRequirements) -> tuple[RecordedRequirement, ...]:
    """Return the results of the requirements of a recorded run, with their margins over time.

    Raises:
        RecordingError: The file is invalid, or a requirement cannot be read by this version.
    """
    requirements = recorded.own()
    if not requirements:
        return ()
    curves = _Curves(requirements)
    verified = recorded.verify(requirements, curves.take)
    return tuple(
        RecordedRequirement(result, np.array(curves.times), np.array(margins), is_of_instants=alone)
        for result, margins, alone in zip(
            verified.results, curves.margins, curves.is_of_instants, strict=True
        )
    )


def read_verified_run(path: Path, robot: str | None = None) -> tuple[RecordedRun, Timeline]:
    """Read a recording, with the results of its requirements, and its timeline.

    The file is read once, and a second time only if there are requirements: what they need is
    known at its end.

    Args:
        robot: See `read_run`.

    Raises:
        RecordingError: The file is invalid, or has no run of a mission.
    """
    file = RecordedFile(path, robot)
    run_reader, timeline_reader = RunReader(file), TimelineReader(file)
    survey = RecordingSurvey(file)
    fold(file, run_reader.take, timeline_reader.take, survey.take)
    run, timeline = run_reader.run(), timeline_reader.timeline()
    try:
        recorded = RecordedRequirements(path, robot=robot, survey=survey)
        run = replace(run, requirements=recorded_requirements(recorded))
    except RecordingError as error:
        missing = "; ".join(filter(None, (run.missing, f"its requirements ({error})")))
        run = replace(run, missing=missing)
    return run, timeline
