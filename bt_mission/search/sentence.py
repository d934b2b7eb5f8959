"""What breaks a mission, in a sentence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bt_mission.core.text import seconds
from bt_mission.executive.report import Report
from bt_mission.faults.planned import Beginning, PlannedFault, Value, WhenTrue
from bt_mission.faults.world import OBSTACLES
from bt_mission.search.candidate import Candidate
from bt_mission.search.guide import Failure


def sentence(failure: Failure, report: Report | None, candidate: Candidate) -> str:
    """Return what breaks, and when it does.

    Args:
        report: Of the run; None leaves out what only that tells, such as the margin.
        candidate: What differs from the mission as it is.
    """
    what = _in_short(failure) if report is None else _what(failure, report)
    return " ".join([what, *_when(candidate)])


def _in_short(failure: Failure) -> str:
    match failure.kind:
        case "violated":
            return f"requirement '{failure.what}' is violated"
        case "collision":
            return "the robot touches something"
        case "orphaned":
            return "a goal is orphaned"
    return f"the mission fails in '{failure.what}'"


def _what(failure: Failure, report: Report) -> str:
    if failure.kind == "violated":
        found = next((one for one in report.requirements if one.name == failure.what), None)
        outcome = "violated" if found is None else found.outcome
        return f"requirement '{failure.what}' is {outcome}"
    if failure.kind == "collision":
        count = report.collisions or 0
        return f"the robot touches something{'' if count == 1 else f' {count} times'}"
    if failure.kind == "orphaned":
        count = report.goals_left_behind
        goals = "a goal is" if count == 1 else f"{count} goals are"
        return f"{goals} orphaned: no server confirms the end"
    if report.status == "interrupted":
        return f"the mission has not ended at {report.virtual_s:g} s"
    leaf = f": '{report.failure.nodes[-1]}' fails" if report.failure else ""
    return f"the mission fails at {seconds(report.virtual_s)}{leaf} ({_first_line(report.reason)})"


def _first_line(text: str) -> str:
    return text.splitlines()[0] if text else "no reason"


def _when(candidate: Candidate) -> list[str]:
    """Return the conditions; none is a mission that breaks as it is."""
    faults = [_fault(one) for one in candidate.faults]
    others = [f"{name}={value}" for name, value in _others(candidate.values).items()]
    if candidate.seed is not None:
        others.append(f"seed {candidate.seed}")
    if not faults and not others:
        return ["with nothing going wrong"]
    found = [f"when {_listed(faults)}"] if faults else []
    return [*found, f"with {_listed(others)}"] if others else found


def _others(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values with the start as one place."""
    place = [values[f"start.{axis}"] for axis in ("x", "y", "yaw") if f"start.{axis}" in values]
    rest = {name: one for name, one in values.items() if not name.startswith("start.")}
    return {**rest, "start": f"({', '.join(f'{one:g}' for one in place)})"} if place else rest


def _fault(fault: PlannedFault) -> str:
    at = _beginning(fault.begins)
    if fault.name in OBSTACLES and "ahead" in fault.arguments:
        what = "a box" if fault.name == "spawn_box" else "a cylinder"
        return f"{what} appears {_place(fault.arguments)} {at}"
    if fault.name == "move_box" and "ahead" in fault.arguments:
        speed = fault.arguments.get("speed", 0.5)
        return f"it moves at {speed:g} m/s to {_place(fault.arguments)} {at}"
    call = fault.call.partition(" lasting ")[0]
    lasting = "" if fault.lasting is None else f" for {fault.lasting:g} s"
    return f"'{call}' begins {at}{lasting}"


def _beginning(begins: Beginning) -> str:
    if isinstance(begins, WhenTrue):
        held = f" for {begins.held_s:g} s" if begins.held_s else ""
        return f"once {begins.condition.text}{held}"
    return f"at {begins.time_s:g} s"


def _place(arguments: Mapping[str, Value]) -> str:
    ahead, left = arguments["ahead"], arguments.get("left", 0.0)
    assert isinstance(ahead, int | float), "it is a length"
    assert isinstance(left, int | float), "it is a length"
    where = f"{abs(ahead):g} m {'ahead' if ahead >= 0 else 'behind'}"
    if left:
        where += f" and {abs(left):g} m to the {'left' if left > 0 else 'right'}"
    return where


def _listed(parts: list[str]) -> str:
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"
