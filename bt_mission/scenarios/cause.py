"""Why a run has not passed: the cause by which failures are grouped."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal, TypeAlias

from bt_mission.scenarios.scenario import ScenarioResult

CauseKind: TypeAlias = Literal[
    "failed", "interrupted", "violated", "not exercised", "untested", "unexpected", "error"
]
"""``failed``: the mission failed. ``interrupted``: it reached its limit. ``violated``: it ended as
expected and violated a requirement. ``not exercised``: the same, but a premise of a requirement
never came true. ``untested``: the same, but a planned fault or server was not used. ``unexpected``:
something else differs from what the scenario expects, such as an orphaned goal. ``error``: the
scenario could not run."""

KINDS: dict[CauseKind, str] = {
    "failed": "failed missions",
    "interrupted": "interrupted missions",
    "violated": "violated requirements",
    "not exercised": "requirements that were not exercised",
    "untested": "faults that never happened, servers that got no goal",
    "unexpected": "other differences",
    "error": "scenarios that could not run",
}
"""The kinds in the order in which they are shown, each with its heading."""

_NUMBER = re.compile(
    r"(?<![\w.])[-+]?(?:\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?|inf\b|nan\b)", re.IGNORECASE
)
_CODE = re.compile(r"\bcode \d+")


@dataclass(frozen=True, order=True)
class Cause:
    """Why runs have not passed; equal for the same cause.

    Attributes:
        place: The names from the root to the leaf that failed, with `` > `` between them; of a
            violation, the requirement.
        reason: The first line of the reason, with ``…`` for each number.
    """

    kind: CauseKind
    place: str = ""
    reason: str = ""


def masked(text: str) -> str:
    """Return a text with ``…`` for each number.

    Digits within a name (``leg2``) and error codes (``code 902``) are names, and stay.
    """
    parts, end = [], 0
    for code in _CODE.finditer(text):
        parts += [_NUMBER.sub("…", text[end : code.start()]), code[0]]
        end = code.end()
    return "".join([*parts, _NUMBER.sub("…", text[end:])])


def kind_of(result: ScenarioResult) -> CauseKind | None:
    """Return the kind of the cause of a result; None where it has passed."""
    report, expected = result.report, result.scenario.expect
    if result.passed:
        return None
    if expected.outcome not in ("any", report.status):
        if report.status == "success":
            return "unexpected"
        return "interrupted" if report.status == "interrupted" else "failed"
    verdicts = {
        requirement.verdict
        for requirement in report.requirements
        if requirement.name not in expected.violated
    }
    kinds: tuple[CauseKind, ...] = ("violated", "not exercised")
    untested: CauseKind = "untested" if report.untested else "unexpected"
    return next((kind for kind in kinds if kind in verdicts), untested)
