"""Planned faults with the places where they are written, for errors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace

from bt_mission.core.diagnostics import Diagnostic, InputError, fault_at
from bt_mission.executive.report import Report
from bt_mission.faults.fault import FaultTarget
from bt_mission.faults.faults import Faults
from bt_mission.faults.plan import FaultPlan, FaultProblem
from bt_mission.faults.planned import PlannedFault
from bt_mission.faults.targets import StageTarget
from bt_mission.faults.text import parse_fault
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.sessions.stage import Stage

OPTION = "--fault"

_DELAYS = frozenset(("delay", "delay_feedback", "delay_service"))
"""Faults whose delays are usually milliseconds; results and answers may be late by minutes."""

_LONG_DELAY_S = 20.0
"""A number without a unit is taken for milliseconds from here: no network delays by so long."""


@dataclass(frozen=True)
class WrittenFault:
    """A planned fault, and what finds the place of a part of its text."""

    planned: PlannedFault
    locate: Callable[[str, str | None, str, int], Diagnostic]
    """Makes an error of a message, a hint, a part of the text and an offset in it."""

    def doubts(self) -> Iterator[Diagnostic]:
        """Yield a warning for each delay without a unit that looks as if in milliseconds."""
        if self.planned.name not in _DELAYS:
            return
        for name in sorted(self.planned.bare & {"by", "jitter"}):
            value = self.planned.arguments.get(name)
            if isinstance(value, int | float) and value >= _LONG_DELAY_S:
                message = f"'{name}' is in seconds: {value:g} s; {value:g} ms?"
                hint = f"write '{value:g} ms' or '{value:g} s'"
                yield replace(self.locate(message, hint, f"{value:g}", 0), severity="warning")

    def diagnostic(self, problem: FaultProblem) -> Diagnostic:
        """Return a problem with its place."""
        return self.locate(problem.message, problem.hint, problem.part, problem.offset)


def fault_in_text(text: str, file: str = OPTION) -> WrittenFault:
    """Return the fault that a text describes.

    Raises:
        InputError: With its place.
    """

    def locate(message: str, hint: str | None, part: str, offset: int) -> Diagnostic:
        column = max(text.find(part), 0) + offset + 1
        return fault_at((1, column), file, [text], message, hint)

    try:
        return WrittenFault(parse_fault(text), locate)
    except ExpressionError as error:
        raise InputError(
            [fault_at((1, error.column), file, [text], error.message, error.hint)]
        ) from None


def faults_in_texts(texts: Sequence[str]) -> tuple[WrittenFault, ...]:
    """Return the faults of options. Raises InputError, with everything that is wrong."""
    found: list[WrittenFault] = []
    wrong: list[Diagnostic] = []
    for text in texts:
        try:
            found.append(fault_in_text(text))
        except InputError as error:
            wrong += error.faults
    if wrong:
        raise InputError(wrong)
    return tuple(found)


def planned_on(
    stage: Stage, written: Sequence[WrittenFault]
) -> AbstractContextManager[Callable[[Report], Report]]:
    """Have faults begin in a run on the stage that no test moves on: see :func:`planned_in`."""
    return planned_in(StageTarget(stage), written)


@contextmanager
def planned_in(
    target: FaultTarget, written: Sequence[WrittenFault], faults: Faults | None = None
) -> Iterator[Callable[[Report], Report]]:
    """Have faults begin in a run; gives what adds their outcomes to its report.

    Args:
        faults: Makes them; where a test plays servers, those of its stage.

    Raises:
        InputError: For names that are not there, before the run begins; and at the end, where a
            fault could not begin.
    """
    plan = FaultPlan(target, [one.planned for one in written], faults)
    wrong = [written[one.number].diagnostic(one) for one in plan.problems()]
    if wrong:
        raise InputError(wrong)
    try:
        yield lambda report: replace(report, faults=plan.outcomes())
    finally:
        if plan.errors:
            raise InputError(
                written[number].locate(str(error), None, "", 0)
                for number, error in plan.errors.items()
            )
