"""The failures that count, and the score of a run: its distance from one."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Literal, get_args

from bt_mission.scenarios.cause import masked
from bt_mission.scenarios.concrete.row import RequirementMargin, ScenarioRow

Aim = Literal["violated", "failed", "orphaned", "collision", "anything"]
"""The target of a search; ``anything`` is each of the others."""

FailureKind = Literal["violated", "failed", "orphaned", "collision"]
AIMS: tuple[Aim, ...] = get_args(Aim)

CLEARANCE = "keeps clear of everything"
"""The requirement that guides the search for a collision; no file has it."""

CLEARANCE_FORMULA = "always clearance > 0"

WORST = -1.0
"""The score of what was searched for."""

BEST = 1.0


ASSUMED, BRANCH = "assumed: ", "branch: "
"""Prefixes of requirements that only a search has: assumptions of the ranges, and distances to
branches that no run has taken.
"""


def is_hidden(name: str) -> bool:
    """Return whether a requirement is the search's own."""
    return name == CLEARANCE or name.startswith((ASSUMED, BRANCH))


@dataclass(frozen=True)
class FoundFailure:
    """A failure of a mission; equal for the same cause.

    Attributes:
        what: The requirement, or the leaf that failed; empty without more detail.
        node: The node whose failure was last, if the mission has not succeeded.
        reason: The reason of such a mission, with each number masked.
    """

    kind: FailureKind
    what: str = ""
    node: str = ""
    reason: str = ""

    def is_like(self, other: FoundFailure) -> bool:
        """Return whether another failure is the same, even if its run ends sooner."""
        same = (self.kind, self.what) == (other.kind, other.what)
        return same and (self.kind != "failed" or self.reason == other.reason)


class Guide:
    """Scores runs, compared with that of the mission as it is.

    It learns from runs in their order (`learn`), so that a search can be repeated.

    Args:
        aim: The target of the search.
        as_it_is: The run of the mission without changes: its margins count as 1.
    """

    def __init__(self, aim: Aim, as_it_is: ScenarioRow) -> None:
        self._kinds = get_args(FailureKind) if aim == "anything" else (aim,)
        self._usual = {
            name: requirement.margin
            for name, requirement in as_it_is.requirements.items()
            if requirement.margin
        }
        self._has_booleans = bool({"failed", "orphaned"} & set(self._kinds)) or (
            "violated" in self._kinds
            and any(
                name not in self._usual and not is_hidden(name) for name in as_it_is.requirements
            )
        )
        self._reached: Counter[int] = Counter()
        self._taken: set[str] = set()

    def learn(self, row: ScenarioRow) -> None:
        """Take note of what of the tree a run has reached."""
        self._reached.update(_places(row))
        self._taken |= {
            name
            for name, requirement in row.requirements.items()
            if requirement.verdict == "violated"
        }

    def is_assumed(self, row: ScenarioRow) -> bool:
        """Return whether a run satisfies the assumptions."""
        return not any(
            name.startswith(ASSUMED) and requirement.verdict == "violated"
            for name, requirement in row.requirements.items()
        )

    def failures(self, row: ScenarioRow) -> tuple[FoundFailure, ...]:
        """Return what a run shows of what is searched for, the worst first."""
        if row.is_error or not self.is_assumed(row):
            return ()
        end: tuple[str, str] = ("", "")
        if row.outcome != "success":
            end = row.failed_node, masked(row.reason.partition("\n")[0])
        failures: list[FoundFailure] = []
        if "violated" in self._kinds:
            broken = [
                (self._share(name, requirement), name)
                for name, requirement in row.requirements.items()
                if requirement.verdict == "violated" and not is_hidden(name)
            ]
            failures += [FoundFailure("violated", name, *end) for _, name in sorted(broken)]
        if "collision" in self._kinds and row.collisions:
            failures.append(FoundFailure("collision", "", *end))
        if "orphaned" in self._kinds and row.orphaned_goals:
            failures.append(FoundFailure("orphaned", "", *end))
        if "failed" in self._kinds and row.outcome != "success":
            failures.append(FoundFailure("failed", failed_by(row), *end))
        return tuple(failures)

    def score(self, row: ScenarioRow) -> float:
        """Return the score of a run: from 1, far from the target, to -1, a failure.

        It is the smallest margin of all requirements, each as a share of its margin in the mission
        as it is. Without margins, new places of the tree and the distance to branches that no run
        has taken count; with both, the mean counts.
        """
        if row.is_error or not self.is_assumed(row):
            return BEST
        if self.failures(row):
            return WORST
        margin = min([share for share, _ in self._margins(row)], default=None)
        if not self._has_booleans:
            return BEST if margin is None else margin
        new = self._novelty(row)
        return new if margin is None else (margin + new) / 2

    def smallest(self, row: ScenarioRow) -> tuple[float, str] | None:
        """Return the smallest margin of a run as a share, and the requirement's name."""
        return min(self._margins(row), default=None)

    def _novelty(self, row: ScenarioRow) -> float:
        """Return how little a run has reached first: from 1, nothing, to 0.

        Half of it is the place of the tree that fewest runs have reached, `1 / (1 + n)`; the other
        half the nearest branch not taken, `1 / (1 + distance)`, the distance as a share of the
        usual one. The form of the latter is that of A. Arcuri: "It really does matter how you
        normalize the branch distance in search-based software testing", Software Testing,
        Verification and Reliability 23, 2013.
        """
        rarest = max((1 / (1 + self._reached[place]) for place in _places(row)), default=0.0)
        distances = [
            requirement.margin / abs(self._usual.get(name) or 1.0)
            for name, requirement in row.requirements.items()
            if name.startswith(BRANCH)
            and name not in self._taken
            and requirement.margin is not None
        ]
        nearest = max((1 / (1 + max(0.0, distance)) for distance in distances), default=0.0)
        return BEST - 0.5 * rarest - 0.5 * nearest

    def _margins(self, row: ScenarioRow) -> list[tuple[float, str]]:
        if row.is_error or not self.is_assumed(row):
            return []
        names = {CLEARANCE} if "collision" in self._kinds else set()
        if "violated" in self._kinds:
            names |= {name for name in row.requirements if not is_hidden(name)}
        return [
            (self._share(name, requirement), name)
            for name, requirement in row.requirements.items()
            if name in names
            and requirement.margin is not None
            and (self._usual.get(name) or requirement.verdict == "violated")
        ]

    def _share(self, name: str, margin: RequirementMargin) -> float:
        if margin.margin is None:
            return WORST if margin.verdict == "violated" else BEST
        usual = abs(self._usual.get(name) or 1.0)
        return max(WORST, min(BEST, margin.margin / usual))


def _places(row: ScenarioRow) -> list[int]:
    """Return the numbers of the places of the tree that a run has reached."""
    bits = int(row.coverage or "0", 16)
    return [number for number in range(bits.bit_length()) if bits >> number & 1]


def failed_by(row: ScenarioRow) -> str:
    """Return the reason of a mission that has not succeeded: the leaf, or that it did not end."""
    if row.outcome == "interrupted":
        return "runs until its limit"
    return row.failed_node or row.outcome
