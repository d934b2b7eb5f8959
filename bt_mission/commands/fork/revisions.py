"""The revisions of a recorded mission, applied again at their instants."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from bt_mission.commands.fork.source import RecordedRevision
from bt_mission.sessions.session import StepCallback
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import StageRun

MOST_ROUNDS = 20
"""Rounds of callbacks after a tick in which a revision waits for its turn."""


class RepeatedRevisions:
    """Applies recorded revisions to a run that is on the stage again.

    A revision happened before a tick, after a tick of the same instant, or after the step. The
    callbacks of its instant that came first have their lines in the trace before it.

    Args:
        stage: The stage.
        run: The run of the mission.
        revisions: The revisions, in order.
        is_due: Whether the run has all lines of the trace that came before a revision.
    """

    def __init__(
        self,
        stage: Stage,
        run: StageRun,
        revisions: Iterable[RecordedRevision],
        is_due: Callable[[RecordedRevision], bool],
    ) -> None:
        self._stage, self._run, self._is_due = stage, run, is_due
        self._waiting = list(revisions)
        for revised in self._waiting:
            if revised.time_ns <= stage.now_ns:
                continue  # before the first step
            stage.clock.call_at(revised.time_ns, partial(self._begin, revised))
        if self._waiting:
            stage.attach(StepCallback(self._after_step))

    def _begin(self, revised: RecordedRevision) -> None:
        """Apply a revision at the begin of its instant, or after the tick of it."""
        if revised.is_after_step:
            return
        cycles = self._run.executive.cycles
        if cycles >= revised.cycle and self._is_due(revised):
            self._apply(revised)
        elif cycles < revised.cycle:
            self._stage.clock.create_task(self._after_tick, revised)

    async def _after_tick(self, revised: RecordedRevision) -> None:
        await self._run.runner.next_tick()
        self._wait(revised, MOST_ROUNDS)

    def _wait(self, revised: RecordedRevision, rounds: int) -> None:
        if self._is_due(revised):
            self._apply(revised)
        elif rounds:
            self._stage.clock.create_task(self._wait, revised, rounds - 1)

    def _after_step(self) -> None:
        """Apply what remains of this instant."""
        while self._waiting and self._waiting[0].time_ns <= self._stage.now_ns:
            self._apply(self._waiting[0])

    def _apply(self, revised: RecordedRevision) -> None:
        if revised not in self._waiting:
            return
        self._waiting.remove(revised)
        runner = self._run.runner
        revision = runner.revise(revised.written, keep_goals=revised.keep_goals)
        if revision.is_refused:
            runner.log(f"the recorded revision is refused here: {'; '.join(revision.reasons)}")
