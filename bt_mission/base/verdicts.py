"""The verdicts of requirements, and the results that have them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, Protocol, TypeAlias, get_args

from bt_mission.base.text import seconds

Verdict: TypeAlias = Literal[
    "violated", "not exercised", "unknown", "open", "holds", "not applicable"
]
"""``holds``: true for the whole run. ``violated``: false. ``not exercised``: not violated, but a
premise never came true. ``not applicable``: the same of a requirement that says that it may not
apply. ``open``: the run was over, or cut, before it could be decided. ``unknown``: a signal is not
known or never had a value."""

VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
"""Every verdict, in the order in which they are shown."""

FAILING: frozenset[str] = frozenset(("violated", "not exercised"))
"""Verdicts with which a run has not passed."""

VACUOUS: frozenset[str] = frozenset(("not exercised", "not applicable"))
"""Verdicts of a run that shows nothing of the requirement."""


OnViolation = Literal["report", "fail", "halt", "measure"]
"""The reaction to a requirement that does not hold."""


@dataclass(frozen=True)
class RequirementResult:
    """The verdict of a requirement.

    Attributes:
        margin: By how much it holds; below 0 by how much it is violated. None where it has no
            measure.
        unit: Of the margin.
        at: The instant that decides the margin, s since the start.
        violated_at: When the violation was noticed, s since the start.
        why: Why it is open or unknown, or which premise never came true.
        sources: Signals that are measured where a simulation would know the truth, such as
            ``speed by odometry``.
        unmet: The message of each premise that has not come true.
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
    unmet: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.name}: {self.outcome}"

    @property
    def fails(self) -> bool:
        """Whether a run with this result has not passed."""
        return self.verdict in FAILING

    @property
    def shown(self) -> RequirementResult:
        """The same without a margin where the run shows nothing of the requirement."""
        return replace(self, margin=None, unit="", at=None) if self.verdict in VACUOUS else self

    @property
    def outcome(self) -> str:
        """Verdict, margin, instant and reason as text."""
        has_measure = self.margin is not None and self.verdict in ("holds", "violated")
        measure = (
            "" if not has_measure else f" by {abs(self.margin or 0.0):.4g} {self.unit}".rstrip()
        )
        when = "" if self.at is None or self.verdict in VACUOUS else f" at {seconds(self.at)}"
        why = f": {self.why}" if self.why else ""
        sources = f" ({', '.join(self.sources)})" if self.sources else ""
        return f"{self.verdict}{measure}{when}{sources}{why}"


class Judged(Protocol):
    """A requirement with its verdict."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def verdict(self) -> str:
        """Its verdict."""


UNTESTED = "untested"
"""The verdict of a run in which something that was planned never happened."""


def conclusion(
    status: str, reason: str, requirements: Iterable[Judged], untested: Sequence[str] = ()
) -> tuple[str, str]:
    """Return the verdict of a run in one word, and its reason.

    It is the status of the mission. A mission that succeeds with a requirement that fails has the
    verdict of that requirement, and one in which something planned never happened is untested.

    Args:
        untested: What never happened, a line each.
    """
    if status != "success":
        return status, reason
    failing = [requirement for requirement in requirements if requirement.verdict in FAILING]
    if not failing and not untested:
        return status, reason
    if failing:
        word = min(failing, key=lambda each: VERDICTS.index(each.verdict)).verdict
        why = ", ".join(f"'{each.name}'" for each in failing if each.verdict == word)
    else:
        word, why = UNTESTED, ", ".join(untested)
    return word, f"{why}; the mission itself succeeded"
