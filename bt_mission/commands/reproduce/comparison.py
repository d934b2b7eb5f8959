"""The differences of a simulated run from the recorded one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

import numpy as np

from bt_mission.commands.reproduce.evidence import Evidence, Path2D
from bt_mission.recording.goal_lives import RecordedGoal

STEP_S = 0.1
NEAR_M = 0.1
"""A path is repeated if it differs by less in the mean."""
LATE_S = 1.0
"""An event is at another time if it differs by more."""
MOST_PATH_M = 5.0


@dataclass(frozen=True)
class RunEnd:
    """The end of a run: outcome, and the violated requirements.

    Attributes:
        missing_faults: Of a simulated run: the planned faults that never happened.
    """

    outcome: str
    violated: tuple[str, ...]
    reason: str = ""
    missing_faults: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {"outcome": self.outcome, "violated": list(self.violated), "reason": self.reason}


@dataclass(frozen=True)
class ComparedEvent:
    """An event of both runs, with its times, s since the start; None where it is missing."""

    what: str
    recorded: float | None
    simulated: float | None


@dataclass(frozen=True)
class RunComparison:
    """The differences of two runs.

    Attributes:
        mean: Of the distance of both paths at the same times, m; None without a path.
        largest: The same, m.
        recorded: The outcomes of the goals, in order.
        simulated: The same.
    """

    mean: float | None
    largest: float | None
    recorded: Sequence[str]
    simulated: Sequence[str]
    events: Sequence[ComparedEvent]
    wanted: RunEnd
    got: RunEnd

    @property
    def is_repeated(self) -> bool:
        """Whether the simulated run ends as the recorded one, with every fault of its scenario."""
        ends_so = self.wanted.outcome in ("any", self.got.outcome)
        violates = set(self.wanted.violated) <= set(self.got.violated)
        return ends_so and violates and not self.got.missing_faults

    @property
    def outcomes_agree(self) -> bool:
        """Whether goals end in the same order in the same way, if the recording has any."""
        return not self.recorded or list(self.recorded) == list(self.simulated)

    @property
    def is_near(self) -> bool:
        """Whether a search need not improve it."""
        is_near = self.mean is None or self.mean < NEAR_M
        return self.is_repeated and self.outcomes_agree and is_near

    @property
    def score(self) -> float:
        """How far the runs differ; 0 for none."""
        score = min(self.mean or 0.0, MOST_PATH_M)
        missing = set(self.wanted.violated) - set(self.got.violated)
        score += 0.5 * len(self.got.missing_faults)
        score += 0.5 * len(missing) + 0.5 * (self.wanted.outcome not in ("any", self.got.outcome))
        pairs = list(zip_longest(self.recorded, self.simulated))
        if not self.outcomes_agree:
            score += 0.4 * sum(a != b for a, b in pairs) / max(len(pairs), 1)
        late = [
            abs(event.recorded - event.simulated)
            for event in self.events
            if event.recorded is not None and event.simulated is not None
        ]
        return float(score) + 0.02 * min(max(late, default=0.0), 10.0)


def compare(recorded: Evidence, simulated: Evidence, wanted: RunEnd, got: RunEnd) -> RunComparison:
    """Compare two runs; times count from the first goal of each."""
    mean, largest = _paths(best(recorded), best(simulated), recorded.end_s, simulated.end_s)
    return RunComparison(
        mean,
        largest,
        [goal.outcome for goal in recorded.goals],
        [goal.outcome for goal in simulated.goals],
        _events(recorded, simulated),
        wanted,
        got,
    )


def best(evidence: Evidence) -> Path2D:
    """Return the path that is known best: the true one of a simulation."""
    return evidence.truth if len(evidence.truth) > 1 else evidence.track


def _paths(
    recorded: Path2D, simulated: Path2D, recorded_s: float, simulated_s: float
) -> tuple[float | None, float | None]:
    if len(recorded) < 2 or len(simulated) < 2:
        return None, None
    # The robot stands where it is once its run has ended.
    end = min(max(recorded_s, simulated_s), recorded_s)
    times = np.arange(0.0, max(end, STEP_S), STEP_S)
    x0, y0, _ = recorded.at(times)
    x1, y1, _ = simulated.at(times)
    apart = np.hypot(x0 - x1, y0 - y1)
    return float(apart.mean()), float(apart.max())


def _events(recorded: Evidence, simulated: Evidence) -> list[ComparedEvent]:
    events: list[ComparedEvent] = []
    if not recorded.goals:  # those of the simulation are ours
        return events
    for number, (a, b) in enumerate(zip_longest(recorded.goals, simulated.goals), 1):
        goal = a or b
        assert goal is not None, "one of them is the longer"
        action = goal.action.strip("/")
        events.append(
            ComparedEvent(
                f"goal {number} ({action}) is sent",
                None if a is None else recorded.since_start(a.start_ns),
                None if b is None else simulated.since_start(b.start_ns),
            )
        )
        ends = [
            None if each is None or each.end_ns is None else run.since_start(each.end_ns)
            for each, run in ((a, recorded), (b, simulated))
        ]
        if ends != [None, None]:
            events.append(ComparedEvent(f"goal {number} ({action}) ends", ends[0], ends[1]))
    return events


def differences(comparison: RunComparison) -> list[str]:
    """Return what the simulation does not show as the recording does."""
    lines = []
    wanted, got = comparison.wanted, comparison.got
    if wanted.outcome not in ("any", got.outcome):
        reason = f" ({got.reason})" if got.reason else ""
        lines.append(
            f"the recorded run ends in {wanted.outcome}, the simulated one in {got.outcome}{reason}"
        )
    lines += [
        f"requirement '{name}' is violated in the recorded run only"
        for name in wanted.violated
        if name not in got.violated
    ]
    lines += [f"fault '{fault}' never happens in the simulation" for fault in got.missing_faults]
    if not comparison.outcomes_agree:
        lines.append(
            f"goals end as {_listed(comparison.recorded)} in the recording, as "
            f"{_listed(comparison.simulated)} in the simulation"
        )
    if comparison.mean is not None and comparison.mean >= NEAR_M:
        lines.append(
            f"the paths differ by {comparison.mean:.2f} m in the mean, "
            f"{comparison.largest or 0.0:.2f} m at most"
        )
    for event in comparison.events:
        if event.recorded is None or event.simulated is None:
            continue
        late = event.simulated - event.recorded
        if abs(late) > LATE_S:
            when = "later" if late > 0 else "earlier"
            lines.append(f"{event.what} {abs(late):.1f} s {when} in the simulation")
    return lines


def _listed(outcomes: Sequence[str]) -> str:
    return ", ".join(outcomes) or "none"


def outcome_of(evidence: Evidence) -> str:
    """Return the outcome of a recorded run by its goals."""
    goals = evidence.goals
    if not goals:
        return "any"
    last = goals[-1]
    if last.outcome == "succeeded":
        return "success"
    is_open = last.outcome == "lost" and last.served_end_ns is None and not last.cancels
    if is_open and last.answered_ns and _ends_at_once(evidence, last):
        return "interrupted"
    return "failure"


def _ends_at_once(evidence: Evidence, goal: RecordedGoal) -> bool:
    """Return whether a recording ends while a goal is under way."""
    moves = evidence.commands[np.abs(evidence.commands[:, 1:]).sum(axis=1) > 1e-6]
    newest = evidence.since_start(goal.feedback[-1][0]) if goal.feedback else -math.inf
    newest = max(newest, float(moves[-1, 0]) if len(moves) else -math.inf)
    return evidence.end_s - newest < 0.3
