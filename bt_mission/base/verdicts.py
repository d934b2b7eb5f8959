"""The verdicts of requirements."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal, Protocol, TypeAlias, get_args

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
