"""Planned faults with the places where they are written, for errors."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from typing import Protocol

from bt_mission.base.diagnostics import (
    Diagnostic,
    InputError,
    diagnostic_at,
    did_you_mean,
    listed,
    quoted,
)
from bt_mission.executive.report import Report
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.scenarios.faults.fault import FaultTarget
from bt_mission.scenarios.faults.plan import FaultPlan, FaultProblem
from bt_mission.scenarios.faults.planned import PlannedFault
from bt_mission.scenarios.faults.targets import StageTarget
from bt_mission.scenarios.faults.text import parse_fault
from bt_mission.scenarios.faults.world import OF_THE_WORLD
from bt_mission.sessions.stage import Stage

OPTION = "--fault"

_DELAYS = frozenset(("delay", "delay_feedback", "delay_service"))
"""Faults whose delays are usually milliseconds; results and answers may be late by minutes."""

_LONG_DELAY_S = 20.0
"""A number without a unit is taken for milliseconds from here: no network delays by so long."""

_ROBOT = re.compile(r"\s*(\w+)\s*:\s*")
"""The robot of a fleet with which a fault begins."""


class WithOutcomes(Protocol):
    """Adds what became of planned faults to the report of a run."""

    def __call__(self, report: Report, robot: str = "") -> Report:
        """Return the report of a robot with those of its faults."""


@dataclass(frozen=True)
class WrittenFault:
    """A planned fault, and what finds the place of a part of its text."""

    planned: PlannedFault
    locate: Callable[[str, str, str | None, str, int], Diagnostic]
    """Makes a diagnostic of code, message, hint, a part of the text and an offset in it."""
    robot: str = ""
    """Of a fleet: the robot that it is for; empty is each."""

    def doubts(self) -> Iterator[Diagnostic]:
        """Yield a warning for each delay without a unit that looks as if in milliseconds."""
        if self.planned.name not in _DELAYS:
            return
        for name in sorted(self.planned.bare & {"by", "jitter"}):
            value = self.planned.arguments.get(name)
            if isinstance(value, int | float) and value >= _LONG_DELAY_S:
                message = f"'{name}' is in seconds: {value:g} s; {value:g} ms?"
                hint = f"write '{value:g} ms' or '{value:g} s'"
                yield replace(
                    self.locate("BT-710", message, hint, f"{value:g}", 0), severity="warning"
                )

    def diagnostic(self, problem: FaultProblem) -> Diagnostic:
        """Return a problem with its place."""
        return self.locate(
            problem.code, problem.message, problem.hint, problem.part, problem.offset
        )


def fault_in_text(text: str, robots: Sequence[str] = ()) -> WrittenFault:
    """Return the fault that a text describes: ``at 5.0: drop scan``, ``robot1: at 5.0: ...``.

    Args:
        robots: Of a fleet: the names that the text may begin with.

    Raises:
        InputError: With its place.
    """
    named = _ROBOT.match(text) if robots else None
    robot, start = ("", 0) if named is None else (named[1], named.end())

    def at(code: str, column: int, message: str, hint: str | None) -> Diagnostic:
        return diagnostic_at(code, (1, column), OPTION, [text], message, hint)

    def locate(code: str, message: str, hint: str | None, part: str, offset: int) -> Diagnostic:
        return at(code, max(text.find(part, start), start) + offset + 1, message, hint)

    if robot and robot not in robots:
        message = f"no robot {quoted(robot)} (the fleet's robots: {listed(robots)})"
        raise InputError([at("BT-707", 1, message, did_you_mean(robot, robots))])
    try:
        planned = parse_fault(text[start:])
    except ExpressionError as error:
        raise InputError(
            [at(error.code, start + error.column, error.message, error.hint)]
        ) from None
    if robots and not robot and planned.name in OF_THE_WORLD:
        message = f"{planned.name} is for one robot: begin with its name, '{robots[0]}: {text}'"
        raise InputError([at("BT-707", 1, message, None)])
    return WrittenFault(planned, locate, robot)


def faults_in_texts(texts: Sequence[str], robots: Sequence[str] = ()) -> tuple[WrittenFault, ...]:
    """Return the faults of options. Raises InputError, with all errors."""
    faults: list[WrittenFault] = []
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
    stage: Stage, written: Sequence[WrittenFault], target: FaultTarget | None = None
) -> AbstractContextManager[WithOutcomes]:
    """Have faults begin on a stage that no test moves on: see :func:`planned_in`.

    Args:
        target: Its only robot, if that has faults of another source, too.
    """
    targets = [StageTarget(stage, run) for run in stage.runs] if target is None else [target]
    return planned_in(targets, written)


@contextmanager
def planned_in(
    targets: Sequence[FaultTarget], written: Sequence[WrittenFault]
) -> Iterator[WithOutcomes]:
    """Have faults begin for robots; gives what adds the outcomes to their reports.

    Args:
        targets: The robots of a stage.

    Raises:
        InputError: For names that are not there, before the run begins; and at the end, where a
            fault could not begin.
    """
    plans: dict[str, tuple[list[WrittenFault], FaultPlan]] = {}
    wrong: list[Diagnostic] = []
    for target in targets:
        robot = target.robot_run.name
        own = [written_fault for written_fault in written if written_fault.robot in ("", robot)]
        plan = FaultPlan(target, [written_fault.planned for written_fault in own])
        plans[robot] = own, plan
        for problem in plan.problems():
            fault = own[problem.number]
            each, is_named = fault.diagnostic(problem), fault.robot == robot
            wrong.append(each if is_named else replace(each, message=f"{each.message} [{robot}]"))
    if wrong:
        raise InputError(wrong)
    try:
        yield lambda report, robot="": replace(report, faults=plans[robot][1].outcomes())
    finally:
        if errors := [
            own[number].locate("BT-704", str(error), None, "", 0)
            for own, plan in plans.values()
            for number, error in plan.errors.items()
        ]:
            raise InputError(errors)
