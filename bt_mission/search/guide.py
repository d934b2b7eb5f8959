"""What counts as found, and how near a run came to it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from bt_mission.sweeps.row import RequirementMargin, ScenarioRow

Aim = Literal["violated", "failed", "orphaned", "collision", "anything"]
"""What is searched for; ``anything`` is each of the others."""

FailureKind = Literal["violated", "failed", "orphaned", "collision"]
AIMS: tuple[Aim, ...] = get_args(Aim)

CLEARANCE = "keeps clear of everything"
"""The requirement that guides the search for a collision; it is in no file."""

CLEARANCE_FORMULA = "always clearance > 0"

WORST = -1.0
"""The score of what was searched for."""

BEST = 1.0


@dataclass(frozen=True)
class Failure:
    """How a run breaks its mission; equal for the same failure.

    Attributes:
        what: The requirement, or the leaf that failed and why in a word; empty where there is
            nothing more to say.
    """

    kind: FailureKind
    what: str = ""


def default_aim(*, has_requirements: bool) -> Aim:
    """What is searched for where nobody says: a violated requirement, if there are any."""
    return "violated" if has_requirements else "anything"


class Guide:
    """Judges runs, beside that of the mission as it is.

    Args:
        aim: What is searched for.
        as_it_is: The run of the mission with nothing varied: its margins count as 1.
    """

    def __init__(self, aim: Aim, as_it_is: ScenarioRow) -> None:
        self._kinds = get_args(FailureKind) if aim == "anything" else (aim,)
        self._usual = {
            name: one.margin for name, one in as_it_is.requirements.items() if one.margin
        }

    def failures(self, row: ScenarioRow) -> tuple[Failure, ...]:
        """Return what a run shows of what is searched for, the worst first."""
        if row.is_error:
            return ()
        found: list[Failure] = []
        if "violated" in self._kinds:
            broken = [
                (self._share(name, one), name)
                for name, one in row.requirements.items()
                if one.verdict == "violated" and name != CLEARANCE
            ]
            found += [Failure("violated", name) for _, name in sorted(broken)]
        if "collision" in self._kinds and row.collisions:
            found.append(Failure("collision"))
        if "orphaned" in self._kinds and row.orphaned_goals:
            found.append(Failure("orphaned"))
        if "failed" in self._kinds and row.outcome != "success":
            found.append(Failure("failed", failed_by(row)))
        return tuple(found)

    def score(self, row: ScenarioRow) -> float:
        """Return how near a run came to what is searched for: from 1, not at all, to -1, there.

        It is the smallest margin of all requirements, each as a share of what it is in the mission
        as it is. What has no margin counts as 1, and -1 where it was found.
        """
        if row.is_error:
            return BEST
        if self.failures(row):
            return WORST
        return min([one for one, _ in self._margins(row)], default=BEST)

    def smallest(self, row: ScenarioRow) -> tuple[float, str] | None:
        """Return the smallest margin of a run as a share, and the requirement's name."""
        return min(self._margins(row), default=None)

    def _margins(self, row: ScenarioRow) -> list[tuple[float, str]]:
        if row.is_error:
            return []
        counts = "violated" in self._kinds
        return [
            (self._share(name, one), name)
            for name, one in row.requirements.items()
            if (counts or ("collision" in self._kinds and name == CLEARANCE))
            and one.margin is not None
            and (self._usual.get(name) or one.verdict == "violated")
        ]

    def _share(self, name: str, margin: RequirementMargin) -> float:
        if margin.margin is None:
            return WORST if margin.verdict == "violated" else BEST
        usual = abs(self._usual.get(name) or 1.0)
        return max(WORST, min(BEST, margin.margin / usual))


def failed_by(row: ScenarioRow) -> str:
    """Return what a mission that has not succeeded failed by: the leaf, or that it went on."""
    if row.outcome == "interrupted":
        return "goes on to its limit"
    return row.failed_node or row.outcome
