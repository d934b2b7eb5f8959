"""The totals of a sweep, added up row by row."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from bt_mission.base.verdicts import VACUOUS, VERDICTS, Verdict
from bt_mission.scenarios.cause import KINDS, Cause, CauseKind
from bt_mission.scenarios.concrete.row import RequirementMargin, ScenarioRow
from bt_mission.scenarios.statistics import samples_as_text, wilson

MOST_GROUPS = 500
"""Kinds of failures that are listed; those of further kinds are counted together."""
OTHER_REASONS = "other reasons"
MASK = 2**64 - 1


@dataclass
class OutcomeCount:
    """The numbers of scenarios by outcome.

    Attributes:
        succeeded: Scenarios that passed.
        failed: Scenarios that ran and did not pass.
        errors: Scenarios that could not run; they count as not succeeded.
        varied: What differs between them, as text.
        known_samples: The samples; runs with the same outcome and signals are one.
    """

    succeeded: int = 0
    failed: int = 0
    errors: int = 0
    varied: str = "the seed"
    known_samples: set[int] = field(default_factory=set, repr=False)

    def add(self, row: ScenarioRow) -> None:
        """Count a row."""
        self.known_samples.add(sample_of(row))
        if row.is_error:
            self.errors += 1
        elif row.passed:
            self.succeeded += 1
        else:
            self.failed += 1

    @property
    def scenarios(self) -> int:
        """All of them."""
        return self.succeeded + self.failed + self.errors

    @property
    def success_rate(self) -> float | None:
        """The share that succeeded, from 0 to 1; None without scenarios."""
        return self.succeeded / self.scenarios if self.scenarios else None

    @property
    def samples(self) -> int:
        """The number of distinct scenarios."""
        return len(self.known_samples)

    @property
    def interval(self) -> tuple[float, float] | None:
        """The 95 % Wilson interval of the rate, by the distinct scenarios; None without any."""
        if not self.scenarios:
            return None
        return wilson(self.succeeded, self.scenarios, self.samples)

    @property
    def samples_in_words(self) -> str:
        """The number of distinct scenarios, as text; empty if all are."""
        return samples_as_text(self.scenarios, self.samples, self.varied)

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON data."""
        return {
            "scenarios": self.scenarios,
            "samples": self.samples,
            "succeeded": self.succeeded,
            "failed": self.failed,
            "errors": self.errors,
            "success_rate": self.success_rate,
            "interval": self.interval,
        }

    def __str__(self) -> str:
        text = f"{self.succeeded:,} of {self.scenarios:,} succeeded"
        if self.interval is None or self.success_rate is None:
            return text
        text += f" ({percent(self.success_rate)}; 95 % confidence interval {span(*self.interval)})"
        return f"{text}; {self.samples_in_words}" if self.samples_in_words else text


def sample_of(row: ScenarioRow) -> int:
    """Return a number that is equal for rows that count as one sample."""
    if row.sample:
        return int(row.sample, 16)
    return hash(row.reason if row.is_error else row.id) & MASK


def percent(share: float) -> str:
    """Return a share in per cent, with enough digits that a rare failure does not vanish."""
    share = round(share, 12)
    for digits in range(1, 9):
        text = f"{100 * share:.{digits}f}"
        if float(text) not in (0, 100) or share in (0, 1):
            break
    return f"{text} %"


def span(low: float, high: float) -> str:
    """An interval of shares in per cent."""
    return f"{percent(low).removesuffix(' %')} to {percent(high)}"


@dataclass
class FailureGroup:
    """Scenarios that have not passed for the same cause.

    Attributes:
        cause: None for those of further causes, which are counted together.
        example: The row with the smallest number.
    """

    cause: Cause | None
    example: ScenarioRow
    count: int = 0
    is_exact: bool = True

    def add(self, row: ScenarioRow) -> None:
        """Count a row."""
        self.count += 1
        self.is_exact = self.is_exact and row.why_failed == self.example.why_failed
        if (row.number, row.id) < (self.example.number, self.example.id):
            self.example = row

    @property
    def node(self) -> str:
        """The leaf that failed."""
        return self.example.failed_node

    @property
    def kind(self) -> CauseKind:
        """The kind of the cause."""
        return self.cause.kind if self.cause else "unexpected"

    @property
    def path(self) -> str:
        """The names from the root to the leaf that failed; empty if none made the run fail."""
        return self.cause.place if self.cause and self.kind in ("failed", "interrupted") else ""

    @property
    def reason(self) -> str:
        """The reason of all in the group, with ``…`` for numbers that differ."""
        if self.cause is None:
            return OTHER_REASONS
        return self.example.why_failed if self.is_exact else self.cause.reason

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON data."""
        return {
            "count": self.count,
            "kind": self.kind,
            "outcome": self.example.outcome,
            "failed_node": self.node,
            "failed_path": self.path,
            "reason": self.reason,
            "example": {
                "id": self.example.id,
                "number": self.example.number,
                "reason": self.example.why_failed,
            },
        }


@dataclass
class RequirementTally:
    """The results of a requirement in all runs.

    Attributes:
        verdicts: The number of each verdict.
        least: The smallest margin; None without a measure.
        unit: That of the smallest margin: of a formula with several measures, whichever decides.
        units: Those of all margins.
        example: The id of the scenario that had it.
        known_samples: The samples in which its premises came true.
    """

    verdicts: Counter[str] = field(default_factory=Counter)
    least: float | None = None
    unit: str = ""
    units: set[str] = field(default_factory=set)
    example: str = ""
    number: int = 0
    known_samples: set[int] = field(default_factory=set, repr=False)

    @property
    def exercised(self) -> int:
        """The number of runs in which its premises came true."""
        return sum(count for verdict, count in self.verdicts.items() if verdict not in VACUOUS)

    @property
    def interval(self) -> tuple[float, float] | None:
        """The 95 % Wilson interval of the share of exercised runs in which it holds.

        None without any.
        """
        if not self.exercised:
            return None
        return wilson(self.verdicts["holds"], self.exercised, len(self.known_samples))

    def add(self, row: ScenarioRow, margin: RequirementMargin) -> None:
        """Count a row's."""
        self.verdicts[margin.verdict] += 1
        if margin.verdict not in VACUOUS:
            self.known_samples.add(sample_of(row))
        if margin.margin is None or margin.verdict in VACUOUS:
            return
        self.units.add(margin.unit)
        if self.least is None or (margin.margin, row.number) < (self.least, self.number):
            self.least, self.unit = margin.margin, margin.unit
            self.number, self.example = row.number, row.id

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON data."""
        return {
            **{verdict: self.verdicts[verdict] for verdict in VERDICTS},
            "interval": self.interval,
            "least_margin": self.least,
            "unit": self.unit,
            "scenario": self.example,
        }


def shown_verdicts(tallies: Iterable[RequirementTally]) -> list[Verdict]:
    """Return the verdicts that tables show: the usual ones, and those of runs without premises."""
    known = {verdict for tally in tallies for verdict, count in tally.verdicts.items() if count}
    return [verdict for verdict in VERDICTS if verdict not in VACUOUS or verdict in known]


@dataclass
class SweepTally:
    """The totals of a sweep; the order of the rows does not matter.

    Attributes:
        count: Of all scenarios.
        virtual_s: ROS time of all runs, s.
        wall_s: Wall time of all runs, s; of several workers, the sum.
        distance_m: Of all robots, m.
        requirements: By their names.
    """

    count: OutcomeCount = field(default_factory=OutcomeCount)
    orphaned_goals: int = 0
    collisions: int = 0
    virtual_s: float = 0.0
    wall_s: float = 0.0
    distance_m: float = 0.0
    requirements: dict[str, RequirementTally] = field(
        default_factory=lambda: defaultdict(RequirementTally)
    )
    _groups: dict[Cause | None, FailureGroup] = field(default_factory=dict, init=False, repr=False)

    def add(self, row: ScenarioRow) -> None:
        """Add a row."""
        self.count.add(row)
        self.orphaned_goals += row.orphaned_goals
        self.collisions += row.collisions or 0
        self.virtual_s += row.virtual_s
        self.wall_s += row.wall_s
        self.distance_m += row.distance_m or 0.0
        if row.parameters or row.plan:
            self.count.varied = "what was varied"
        for name, requirement in row.requirements.items():
            self.requirements[name].add(row, requirement)
        if not row.passed:
            self._group_of(row).add(row)

    def _group_of(self, row: ScenarioRow) -> FailureGroup:
        cause = row.cause
        if cause not in self._groups and len(self._groups) >= MOST_GROUPS:
            cause = None
        if cause not in self._groups:
            self._groups[cause] = FailureGroup(cause, row)
        return self._groups[cause]

    @property
    def failures(self) -> list[FailureGroup]:
        """The groups by kind, within each the most frequent first."""
        kinds = list(KINDS)

        def place(group: FailureGroup) -> tuple[bool, int, int, Cause]:
            cause = group.cause or Cause("unexpected")
            return group.cause is None, kinds.index(group.kind), -group.count, cause

        return sorted(self._groups.values(), key=place)
