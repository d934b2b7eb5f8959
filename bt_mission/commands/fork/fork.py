"""A recorded run that runs again, compared with the recording."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from bt_mission.base.errors import BtMissionError
from bt_mission.base.text import seconds
from bt_mission.commands.fork.change import ForkChange
from bt_mission.commands.fork.revisions import RepeatedRevisions
from bt_mission.commands.fork.source import ForkError, ForkSource, RecordedRevision
from bt_mission.executive.report import Report
from bt_mission.executive.stored_trace import trace_of
from bt_mission.executive.trace_diff import Difference, first_difference

if TYPE_CHECKING:
    from bt_mission.language.mission import Mission
    from bt_mission.sessions.stage import Stage
    from bt_mission.sessions.stage_robot import StageRun

REQUIREMENT = '"event": "requirement"'


@dataclass(frozen=True)
class ForkResult:
    """The result of a fork.

    Args:
        step_ns: The control step of the fork.
        report: The report of the forked run.
        difference: The first difference from the recorded run; None if they are equal.
        same_events: The number of equal events before the fork.
        others: The results of the other robots of a fleet, in which nothing is changed.
    """

    source: ForkSource
    change: ForkChange
    step_ns: int
    report: Report
    difference: Difference | None
    same_events: int
    others: tuple[ForkResult, ...] = ()

    @property
    def is_identical(self) -> bool:
        """Whether the whole run is equal, including that of the other robots."""
        return self.difference is None and all(other.difference is None for other in self.others)

    @property
    def is_success(self) -> bool:
        """Whether the run has passed."""
        return self.report.passed

    @property
    def at_s(self) -> float:
        """The control step of the fork, s since the start."""
        return self.source.seconds(self.step_ns)

    def as_dict(self) -> dict[str, Any]:
        """Return the result as JSON data."""
        status, reason = self.source.outcome
        robot = {"robot": self.source.name} if self.source.name else {}
        others = [other.as_dict() for other in self.others]
        return {
            **robot,
            "recording": str(self.source.path),
            "forked_at": self.at_s,
            "change": self.change.as_dict(),
            "is_identical": self.difference is None,
            "same_events": self.same_events,
            "recorded": {
                "status": status,
                "reason": reason,
                "virtual_s": self.source.summary.get("virtual_s", self.source.end_s),
                "requirements": self.source.requirements,
            },
            "forked": self.report.as_dict(),
            "first_difference": self.difference and asdict(self.difference),
            "other_versions": list(self.source.differences),
            **({"others": others} if others else {}),
        }


class ForkedRun:
    """Compares a run with the recorded one while it runs, and changes it at its instant.

    Args:
        source: The recorded run.
        change: Takes effect at the fork.
        step_ns: The control step of the fork.
        mission: The running mission. Events of requirements that only one of the two has are not
            compared.
        parted: Called with the name of the robot when its run differs before the fork. All runs
            then end, so only the first is the cause.
    """

    def __init__(
        self,
        source: ForkSource,
        change: ForkChange,
        step_ns: int,
        mission: Mission,
        parted: list[str],
    ) -> None:
        self._parted_robots = parted
        self._source = source
        self._change = change
        self._step_ns = step_ns
        self._is_whole = source.is_whole
        others = set(source.mission.requirements) ^ set(mission.requirements)
        self._others = tuple(f'"name": {json.dumps(other.name)}' for other in others)
        self._recorded = [line for line in source.trace if self._is_compared(line)]
        lines = zip(source.trace, source.events, strict=True)
        self._same = sum(
            event.get("t", 0) < step_ns and self._is_compared(line) for line, event in lines
        )
        """The number of lines that have to be equal."""
        self._lines: list[str] = []
        self._parted: int | None = None
        self._error: BtMissionError | None = None
        self._is_telling = False
        """Whether the change is being logged. That is not a difference."""
        self._stage: Stage
        self._run: StageRun

    @property
    def facts(self) -> dict[str, str]:
        """The facts for a recording of the run; empty if it is the same run."""
        change = self._change
        if not change.is_applied:
            return {}  # it runs again unchanged
        known = {"at_s": self._source.seconds(self._step_ns), **change.as_dict()}
        return {"forked_from": self._source.path.name, "changes": json.dumps([known])}

    def follow(self, stage: Stage) -> None:
        """Compare the events on a stage, before its first step."""
        self._stage = stage
        self._run = run = stage[self._source.name]
        for line in run.trace.newest:
            self._take(line)
        run.trace.lines.subscribe(self._take)
        RepeatedRevisions(stage, run, self._revisions, self._is_due)
        if self._change.is_applied:
            stage.clock.call_at(self._step_ns, self._apply)

    def result(self, report: Report) -> ForkResult:
        """Return the result, once the run has ended.

        Raises:
            ForkError: It was not equal up to the fork, with the first difference.
            InputError: The change did not fit the run at its instant.
        """
        if self._error is not None:
            raise self._error
        source, lines = self._source, self._lines
        if self._parted is None and len(lines) < len(self._recorded):
            self._parted = len(lines)
        if self._parted is not None and self._parted < self._same:
            raise ForkError(self._why_not_the_same())
        same = self._same - 1
        difference = self._difference(self._recorded)
        return ForkResult(source, self._change, self._step_ns, report, difference, same)

    @property
    def _revisions(self) -> list[RecordedRevision]:
        """The recorded revisions that happen again: another version replaces the later ones."""
        is_edited = self._change.edit is not None
        return [
            revised
            for revised in self._source.revisions
            if not is_edited or revised.time_ns < self._step_ns
        ]

    def _is_due(self, revised: RecordedRevision) -> bool:
        """Whether the lines before a revision are there, or cannot be expected any more."""
        before = sum(map(self._is_compared, self._source.trace[: revised.line]))
        return self._parted is not None or len(self._lines) >= before

    def _apply(self) -> None:
        try:
            self._change.apply(self._run.runner)
        except BtMissionError as error:
            self._error = error
            self._leave()
            return
        self._is_telling = True
        self._run.runner.log(f"forked here: {self._change}")
        self._is_telling = False

    def _leave(self) -> None:
        for run in self._stage.runs:
            run.executive.abandon("the fork has ended")

    def _take(self, line: str) -> None:
        if self._is_telling:
            return
        if not self._is_compared(line):
            return
        number = len(self._lines)
        self._lines.append(line)
        expected = self._recorded
        # After the end of a cut recording, nothing is known.
        is_known = number < len(expected)
        is_same = expected[number] == line if is_known else not self._is_whole
        if self._parted is None and not is_same:
            self._parted = number
            if number < self._same:  # the run differs: it need not continue
                self._parted_robots.append(self._source.name)
                self._stage.clock.call_at(self._stage.now_ns, self._leave)

    def _is_compared(self, line: str) -> bool:
        has_name = bool(self._others) and REQUIREMENT in line
        return not (has_name and any(name in line for name in self._others))

    def _difference(self, recorded: Sequence[str]) -> Difference | None:
        if self._parted is None:
            return None
        path = str(self._source.path)
        return first_difference(trace_of(path, recorded), trace_of("again", self._lines))

    def _why_not_the_same(self) -> str:
        source = self._source
        assert self._parted is not None
        # The run was stopped soon after the first difference: later ones do not count.
        self._lines = self._lines[: self._parted + 1]
        difference = self._difference(self._recorded[: self._parted + 1])
        at_s = source.seconds(self._step_ns)
        whose = f"{source.name}: " if source.name else ""
        what = (
            f"the repeated run differs from the recording before {seconds(at_s)}, so it "
            f"cannot be forked there"
        )
        lines = [
            f"{source.path}: {whose}{what} (< recorded, > run again)",
            str(difference),
            *source.differences,
        ]
        if self._change.new_tree is not None:
            lines.append(f"the edited mission has another tree: {self._change.new_tree}")
        elif any(event.get("event") == "paused" for event in source.events):
            lines.append("it was paused by hand, and a recording does not contain interventions")
        elif source.outcome[0] == "interrupted":
            lines.append("it was interrupted, and a recording does not contain interventions")
        else:
            lines.append(
                "a recording does not contain interventions by tests, people or other processes"
            )
        return "\n".join(lines)
