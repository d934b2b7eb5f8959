"""Requirements of a mission that goes on after its process has died: two parts, one verdict."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

from bt_mission.language.expressions.syntax import Not, SyntaxNode
from bt_mission.language.requirements.formula import Requirement, walk
from bt_mission.language.requirements.syntax import FUTURE, Chain, Temporal, Timed
from bt_mission.requirements.monitor import RequirementResult

BEFORE = "before the mission was resumed"
SPANS = "it speaks of times across the instant at which the mission was resumed"


def joined(
    requirement: Requirement, before: RequirementResult | None, after: RequirementResult
) -> RequirementResult:
    """Return what a requirement comes to by both parts of a run.

    Nobody saw what happened between them, and what a formula remembered is lost. So what was
    decided before stays; of the rest only what either part can tell by itself is told.

    Args:
        before: None where nothing is known of the first part.
        after: What it came to where the first instant was that of the resumption.
    """
    if before is not None and before.verdict in ("violated", "holds"):
        return replace(before, why=BEFORE)
    if after.verdict == "unknown":
        return after
    quantifier, is_plain = _shape(requirement.root)
    is_told = {
        "violated": quantifier == "always" or is_plain,
        "holds": is_plain or quantifier == "eventually",
    }
    if not is_told.get(after.verdict, True):
        return replace(after, verdict="open", violated_at=None, why=SPANS)
    if not is_plain or before is None or before.margin is None:
        return after
    margin = math.nan if after.margin is None else after.margin
    is_older = before.margin < margin if quantifier == "always" else before.margin > margin
    if not is_older and after.margin is not None:
        return after
    why = f"its margin is from {BEFORE}"
    return replace(after, margin=before.margin, unit=before.unit, at=before.at, why=why)


def _shape(root: SyntaxNode) -> tuple[Literal["always", "eventually"] | None, bool]:
    """Return at which instants a formula speaks of a condition, and whether of that instant alone.

    None is any other formula: one with a window from the start on, with memory, or of several.
    """
    is_negated = False
    while isinstance(root, Not):
        root, is_negated = root.operand, not is_negated
    if not isinstance(root, Temporal) or not root.window.is_everything:
        return None, False
    inner = [one for one in walk(root.operand) if isinstance(one, Timed)]
    words = [one.symbol if isinstance(one, Chain) else one.word for one in inner]
    if any(word not in FUTURE for word in words):
        return None, False
    is_always = (root.word == "always") is not is_negated
    return "always" if is_always else "eventually", not inner
