"""Faults of options and scenarios: read with their places, and planned in a run."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from typing import Protocol

from bt_mission.base.diagnostics import (
    Diagnostic,
    InputError,
    did_you_mean,
    listed,
    quoted,
)
from bt_mission.executive.report import Report
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.scenarios.faults.fault import FaultTarget
from bt_mission.scenarios.faults.plan import FaultPlan
from bt_mission.scenarios.faults.planned import PlannedFault, within
from bt_mission.scenarios.faults.targets import StageTarget
from bt_mission.scenarios.faults.text import parse_fault
from bt_mission.scenarios.faults.world import OF_THE_WORLD
from bt_mission.sessions.stage import Stage

_ROBOT = re.compile(r"\s*(\w+)\s*:\s*")
"""The robot of a fleet with which a fault begins."""


class WithOutcomes(Protocol):
    """Adds what became of planned faults to the report of a run."""

    def __call__(self, report: Report, robot: str = "") -> Report:
        """Return the report of a robot with those of its faults."""


def fault_in_text(text: str, robots: Sequence[str] = ()) -> PlannedFault:
    """Return the fault that a text describes: ``at 5.0: drop scan``, ``robot1: at 5.0: ...``.

    Args:
        robots: Of a fleet: the names that the text may begin with.

    Raises:
        InputError: With its place.
    """
    named = _ROBOT.match(text) if robots else None
    robot, start = ("", 0) if named is None else (named[1], named.end())

    place = within(text, start)
    if robot and robot not in robots:
        message = f"no robot {quoted(robot)} (the fleet's robots: {listed(robots)})"
        raise InputError([within(text)("BT-707", message, did_you_mean(robot, robots), "", 0)])
    try:
        planned = parse_fault(text[start:])
    except ExpressionError as error:
        wrong = place(error.code, error.message, error.hint, "", error.column - 1)
        raise InputError([wrong]) from None
    if robots and not robot and planned.name in OF_THE_WORLD:
        message = f"{planned.name} is for one robot: begin with its name, '{robots[0]}: {text}'"
        raise InputError([within(text)("BT-707", message, None, "", 0)])
    return replace(planned, place=place, robot=robot)


def faults_in_texts(texts: Sequence[str], robots: Sequence[str] = ()) -> tuple[PlannedFault, ...]:
    """Return the faults of options. Raises InputError, with all errors."""
    faults: list[PlannedFault] = []
    wrong: list[Diagnostic] = []
    for text in texts:
        try:
            faults.append(fault_in_text(text, robots))
        except InputError as error:
            wrong += error.diagnostics
    if wrong:
        raise InputError(wrong)
    return tuple(faults)


def planned_on(
    stage: Stage, written: Sequence[PlannedFault], target: FaultTarget | None = None
) -> AbstractContextManager[WithOutcomes]:
    """Have faults begin on a stage that no test moves on: see :func:`planned_in`.

    Args:
        target: Its only robot, if that has faults of another source, too.
    """
    targets = [StageTarget(stage, run) for run in stage.runs] if target is None else [target]
    return planned_in(targets, written)


@contextmanager
def planned_in(
    targets: Sequence[FaultTarget], written: Sequence[PlannedFault]
) -> Iterator[WithOutcomes]:
    """Have faults begin for robots; gives what adds the outcomes to their reports.

    Args:
        targets: The robots of a stage.

    Raises:
        InputError: For names that are not there, before the run begins; and at the end, where a
            fault could not begin.
    """
    plans: dict[str, tuple[list[PlannedFault], FaultPlan]] = {}
    wrong: list[Diagnostic] = []
    for target in targets:
        robot = target.robot_run.name
        own = [fault for fault in written if fault.robot in ("", robot)]
        plan = FaultPlan(target, own)
        plans[robot] = own, plan
        for problem in plan.problems():
            fault = own[problem.number]
            each = fault.locate(
                problem.code, problem.message, problem.hint, problem.part, problem.offset
            )
            is_named = fault.robot == robot
            wrong.append(each if is_named else replace(each, message=f"{each.message} [{robot}]"))
    if wrong:
        raise InputError(wrong)
    try:
        yield lambda report, robot="": replace(report, faults=plans[robot][1].outcomes())
    finally:
        if errors := [
            own[number].locate("BT-704", str(error))
            for own, plan in plans.values()
            for number, error in plan.errors.items()
        ]:
            raise InputError(errors)
