"""Rows of results, made by hand."""

from __future__ import annotations

from typing import Any

from bt_mission.base.verdicts import Verdict
from bt_mission.scenarios.concrete.row import RequirementMargin, ScenarioRow

LOST = "'look around' aborted: no scan for 1 s: the last is 1.05 s old (code 902)"


def row(number: int = 0, **changes: Any) -> ScenarioRow:
    """A run that has passed, with changes."""
    given = {
        "id": f"{number:016x}",
        "number": number,
        "seed": number,
        "world": "dqn_stage4",
        "robot": "waffle",
        "outcome": "success",
        "passed": True,
        "virtual_s": 20.0,
        "wall_s": 0.5,
        "distance_m": 2.0,
        "collisions": 0,
        **changes,
    }
    if not given["passed"]:
        given.setdefault("cause_kind", _kind(given))
    return ScenarioRow(**given)


def _kind(given: dict[str, Any]) -> str:
    """The kind of the cause of a row of a mission."""
    if given["outcome"] == "success":
        return "violated" if given.get("requirements") else "unexpected"
    return "error" if given["outcome"] == "error" else "failed"


def failed(number: int = 0, **changes: Any) -> ScenarioRow:
    """A run whose mission has failed, with changes."""
    given = {
        "outcome": "failure",
        "passed": False,
        "reason": LOST,
        "failed_node": "look around",
        "failed_path": "explore > look around",
        "virtual_s": 2.95,
        **changes,
    }
    return row(number, **given)


def margin(
    value: float | None, verdict: Verdict | None = None, unit: str = "m"
) -> RequirementMargin:
    """What a requirement came to: the verdict follows from the margin unless it is given."""
    reported = verdict or ("violated" if value is not None and value < 0 else "holds")
    return RequirementMargin(reported, value, unit, 1.0)
