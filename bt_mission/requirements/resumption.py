"""Requirements of a mission that is resumed by another process: one verdict of two parts."""

from __future__ import annotations

import math
from dataclasses import replace

from bt_mission.base.verdicts import VACUOUS, RequirementResult, Verdict
from bt_mission.language.expressions.syntax import Not
from bt_mission.language.mission import Requirement
from bt_mission.requirements.language.formula import root_of, walk
from bt_mission.requirements.language.syntax import EVERYTHING, FUTURE, Measure, Temporal

BEFORE = "before the mission was resumed"
SPANS = "it is about times across the instant at which the mission was resumed"


def joined(
    requirement: Requirement, before: RequirementResult | None, after: RequirementResult
) -> RequirementResult:
    """Return the result of a requirement over both parts of a run.

    Nothing was monitored between the parts, and the state of the operators is lost. Earlier
    decisions are kept. Of the other requirements, only those are decided that either part decides
    alone.

    Args:
        before: None where nothing is known of the first part.
        after: Its result where the first instant was that of the resumption.
    """
    if before is not None and before.verdict in ("violated", "holds", *VACUOUS):
        return replace(before, why=BEFORE)
    if after.verdict == "unknown":
        return after
    after = _with_premises(before, after)
    all_of, is_plain = _shape(requirement)
    can_decide = {"violated": is_plain or all_of is True, "holds": is_plain or all_of is False}
    verdict = "holds" if after.verdict in VACUOUS else after.verdict
    if not can_decide.get(verdict, True):
        return replace(after, verdict="open", violated_at=None, why=SPANS)
    if not is_plain or before is None or before.margin is None:
        return after
    margin = math.nan if after.margin is None else after.margin
    is_older = before.margin < margin if all_of else before.margin > margin
    if not is_older and after.margin is not None:
        return after
    why = after.why or f"its margin is from {BEFORE}"
    return replace(after, margin=before.margin, unit=before.unit, at=before.at, why=why)


def _with_premises(before: RequirementResult | None, after: RequirementResult) -> RequirementResult:
    """Return the result of the second part with the premises that neither part has seen."""
    if before is None:
        return after
    unmet = tuple(why_not for why_not in after.unmet if why_not in before.unmet)
    if after.verdict in VACUOUS and unmet != after.unmet:
        verdict: Verdict = after.verdict if unmet else "holds"
        return replace(after, verdict=verdict, unmet=unmet, why=unmet[0] if unmet else "")
    return replace(after, unmet=unmet)


def _shape(requirement: Requirement) -> tuple[bool | None, bool]:
    """Return whether a formula is `always` or `eventually`, and whether of one instant at a time.

    The first is None for any other formula: one with a window from the start on, with memory, or
    of several.
    """
    root, is_positive = root_of(requirement), True
    while isinstance(root, Not):
        root, is_positive = root.operand, not is_positive
    if not isinstance(root, Temporal) or root.window != EVERYTHING:
        return None, False
    inner = [part for part in walk(root) if isinstance(part, Temporal | Measure)][1:]
    if root.word == "until" or any(part.word not in FUTURE for part in inner):
        return None, False
    return (root.word == "always") is is_positive, not inner
