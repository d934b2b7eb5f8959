"""Drives a session to its end, paced, with its onlookers and interrupts."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Generic, TypeAlias, TypeVar

from bt_mission.base.errors import BtMissionError, callback_failure
from bt_mission.base.interrupts import TWO_WISHES, InterruptSignals
from bt_mission.base.wall_clock import Pacer, Stopwatch, rest
from bt_mission.executive.executive import Executive
from bt_mission.executive.leaf_statistics import LeafStatistics
from bt_mission.executive.report import Report
from bt_mission.sessions.session import MissionRun, Onlooker, Session

R = TypeVar("R")
Steps: TypeAlias = Generator[float, None, R]
"""A session on its way to its result: see :func:`driving`."""

Reports: TypeAlias = tuple[Report, ...]
"""The report of each run of a session, in order."""

TURN_S = 0.02
"""Wall time for which steps are taken at a stretch, before keys and pictures have their turn."""


def drive(
    session: Session, onlookers: Sequence[Onlooker] = (), *, speed: float | None = None
) -> Reports:
    """Step a session to its end: see :func:`driving`."""
    return finish(driving(session, onlookers, InterruptSignals(TWO_WISHES), speed=speed))


def finish(steps: Steps[R]) -> R:
    """Take all remaining steps, each when it is due. Return the result."""
    while True:
        try:
            if (wait_s := next(steps)) > 0:
                rest(wait_s)
        except StopIteration as end:
            result: R = end.value
            return result


class StepDriver(Generic[R]):
    """Takes the steps of a session within another event loop.

    Args:
        steps: The session on its way.
    """

    def __init__(self, steps: Steps[R]) -> None:
        self.result: R | None = None
        """Once the session has ended."""
        self.error: Exception | None = None
        """The exception of a step; no step follows it."""
        self._steps = steps

    @property
    def is_over(self) -> bool:
        """Whether there is no further step."""
        return self.result is not None or self.error is not None

    def advance(self) -> float:
        """Take the steps that are due, for :data:`TURN_S`. Return the wall time to the next, s.

        An event loop reports an exception of its callbacks and continues. So this method does not
        raise; :meth:`finish` raises the exception of a step.
        """
        since = Stopwatch()
        wait_s = 0.0
        while not self.is_over and wait_s <= 0 and since.elapsed_s < TURN_S:
            try:
                wait_s = next(self._steps)
            except StopIteration as end:
                self.result = end.value
            except Exception as error:  # noqa: BLE001 - raised again by `finish`
                self.error = error
        return max(wait_s, 0.0)

    def finish(self) -> R:
        """Take all remaining steps, each when it is due. Return the result.

        Raises:
            Exception: The exception of a step.
        """
        if self.error is not None:
            raise self.error
        if self.result is None:
            self.result = finish(self._steps)
        return self.result


def driving(
    session: Session,
    onlookers: Sequence[Onlooker],
    interrupts: InterruptSignals,
    *,
    speed: float | None = None,
    paced_from_ns: int = 0,
) -> Steps[Reports]:
    """Step a session to its end, paced and watched; gives the report of each run.

    The caller takes one step after another. A step yields the wall time until the next is due, s,
    for which to rest or to do other work; a step that is taken too early changes nothing.

    The first Ctrl-C or SIGTERM halts every tree and waits until every goal has ended; the second
    leaves at once, and the reason names the goals left behind. An exception of a step ends the
    missions as failed with the cause, with every goal followed to its end; a second one, or one
    after which the session cannot continue, leaves at once.

    Up to `paced_from_ns`, an instant of ROS time, a session runs as fast as possible.
    """
    wall = Stopwatch()
    ended_s: dict[MissionRun, float] = {}
    with ExitStack() as stack:
        stack.enter_context(interrupts)
        for onlooker in onlookers:
            session.attach(onlooker)
            stack.callback(_part, session, onlooker)
        leaves = [_statistics(run) for run in session.runs]
        pacer = Pacer(speed, session.start_ns)
        is_paced = speed is not None and session.now_ns >= paced_from_ns
        running = {run: run.executive for run in session.runs if not run.executive.status.is_final}
        executives = running.values()
        while running:
            if not _step(session, executives, onlookers, interrupts):
                break
            for run, executive in tuple(running.items()):
                if executive.status.is_final:
                    del running[run]
                    ended_s[run] = wall.elapsed_s
            if speed is not None and not is_paced and session.now_ns >= paced_from_ns:
                pacer.set_speed(speed, session.now_ns)
                is_paced = True
            while is_paced and (ahead_s := pacer.ahead_s(session.now_ns)) > 0:
                if interrupts.count > 0 and running:
                    break
                yield ahead_s
            yield 0.0
    wall_s = wall.elapsed_s
    return tuple(
        replace(session.report(ended_s.get(run, wall_s), run), leaves=of_run.summaries())
        for run, of_run in zip(session.runs, leaves, strict=True)
    )


def _step(
    session: Session,
    executives: Iterable[Executive],
    onlookers: Iterable[Onlooker],
    interrupts: InterruptSignals,
) -> bool:
    """Take one step; return whether the session continues."""
    for onlooker in onlookers:
        if onlooker.why_left:
            _interrupt(executives, onlooker.why_left)
    if interrupts.count:
        _interrupt(executives, f"interrupted by {interrupts.name}")
    if interrupts.count > 1:
        _abandon(executives, f"ended at once by a second {interrupts.name}")
        return False
    try:
        session.step()
    except BtMissionError as error:
        _abandon(executives, error.headline)
    except Exception as error:  # noqa: BLE001 - whatever takes part may raise anything
        _fail(executives, callback_failure(error))
    return True


def _statistics(run: MissionRun) -> LeafStatistics:
    return LeafStatistics(run.executive, lambda: run.distance_travelled_m)


def _part(session: Session, onlooker: Onlooker) -> None:
    onlooker.close()
    session.detach(onlooker)


def _interrupt(executives: Iterable[Executive], reason: str) -> None:
    for executive in executives:
        executive.interrupt(reason)


def _fail(executives: Iterable[Executive], reason: str) -> None:
    for executive in executives:
        if executive.status.is_active:
            executive.fail(reason)
        else:
            executive.abandon(reason)


def _abandon(executives: Iterable[Executive], reason: str) -> None:
    for executive in executives:
        executive.abandon(reason)
