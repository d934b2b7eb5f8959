"""The summary of a run: one object for programs, one paragraph for people."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from bt_mission.base.nature import in_words
from bt_mission.base.stamps import NS
from bt_mission.base.text import counted, escape_control, seconds
from bt_mission.base.verdicts import conclusion
from bt_mission.executive.events.log import verdict

if TYPE_CHECKING:
    from bt_mission.base.verdicts import RequirementResult
    from bt_mission.executive.executive import Executive
    from bt_mission.executive.leaf_statistics import LeafSummary
    from bt_mission.executive.trace import Trace
    from bt_mission.language.mission import Mission


@dataclass(frozen=True)
class FailurePath:
    """The nodes from the root of a tree down to the node whose failure was last.

    Attributes:
        nodes: Their names.
        path: The path of the last one in the tree, such as ``0.1.0``.
        message: Its reason.
        time_s: ROS time of the failure since the start, s.
    """

    nodes: tuple[str, ...]
    path: str
    message: str
    time_s: float


@dataclass(frozen=True)
class FaultOutcome:
    """The outcome of a planned fault.

    Attributes:
        fault: Its text, such as ``at 5.0: drop scan lasting 2``.
        began: When it began, s since the start; None if it did not occur.
        ended: When it ended; None if it lasted to the end of the run.
        why: Why it did not occur.
        may_not_happen: Does a run pass in which it does not occur?
    """

    fault: str
    began: float | None = None
    ended: float | None = None
    why: str = ""
    may_not_happen: bool = False

    @property
    def fails(self) -> bool:
        """Whether a run with this outcome has not passed."""
        return self.began is None and not self.may_not_happen

    @property
    def untested(self) -> str:
        """The line about a fault that a run with this outcome has not shown."""
        return f"'{self.fault}' never happened"

    def __str__(self) -> str:
        if self.began is None:
            return f"{self.fault}: never happened, {self.why}"
        if self.ended is None:
            return f"{self.fault}: from {seconds(self.began)}"
        if self.ended == self.began:
            return f"{self.fault}: at {seconds(self.began)}"
        return f"{self.fault}: from {seconds(self.began)} to {seconds(self.ended)}"


@dataclass(frozen=True)
class Report:
    """The result of a run; `str()` of it is a summary for people.

    Fields that only a simulation knows are None when attached.

    Attributes:
        virtual_s: ROS time from start to end, s.
        wall_s: Wall time of the same, s.
        real_time_factor: Virtual seconds per wall second.
        goals_left_behind: Goals whose end no server confirmed.
        distance_travelled_m: True path length of the robot, m.
        trace_sha256: Equal for two runs in which the same things happened at the same times.
        sample: Equal for two runs with the same outcome and signals, whatever their seeds: these
            are one sample in every statistic.
        nature: What differs from run to run, as it was drawn, by the names of its quantities
            (`docs/reference/nature.md`); empty where nothing was.
        leaves: The statistics of each leaf, if they were counted.
        failure: What made the tree fail; None where that did not.
        requirements: The result of each requirement.
        faults: What became of each fault that was planned.
        untested: What was planned for the run and has not happened, a line each.
        warnings: What may have changed the result, such as a second server of an action.
    """

    mission: str
    status: str
    reason: str
    world: str | None
    robot: str
    seed: int
    virtual_s: float
    wall_s: float
    real_time_factor: float
    ticks: int
    goals_sent: int
    goals_left_behind: int
    collisions: int | None
    distance_travelled_m: float | None
    trace_sha256: str
    sample: str = ""
    nature: Mapping[str, float] = field(default_factory=dict)
    leaves: tuple[LeafSummary, ...] = ()
    failure: FailurePath | None = None
    requirements: tuple[RequirementResult, ...] = ()
    faults: tuple[FaultOutcome, ...] = ()
    untested: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def verdict(self) -> str:
        """The verdict of the run: the mission's status, or that of a requirement that fails."""
        return self.conclusion[0]

    @property
    def conclusion(self) -> tuple[str, str]:
        """The verdict of the run and its reason."""
        return conclusion(self.status, self.reason, self.requirements, self.untested)

    @property
    def passed(self) -> bool:
        """Whether the mission has succeeded, and every requirement was shown or may not apply."""
        return self.verdict == "success"

    @property
    def failing(self) -> str:
        """The requirements and faults that fail as text; empty if none does."""
        failing = [f"requirement {each}" for each in self.requirements if each.fails]
        failing += self.untested
        return "; ".join(failing)

    def __str__(self) -> str:
        return self.as_text()

    @property
    def missions(self) -> Mapping[str, Report]:
        """The report by the robot's name, which is empty; as `FleetReport.missions`."""
        return {"": self}

    def as_dict(self) -> dict[str, Any]:
        """The fields by name, and the verdict, ready for JSON."""
        return {"verdict": self.verdict, **asdict(self)}

    def as_text(self) -> str:
        """Three or four lines for people."""
        lines = [f"{self.mission}: {verdict(*self.conclusion)}"]
        if self.failure is not None and len(self.failure.nodes) > 1:
            message = "" if self.failure.message in self.reason else f": {self.failure.message}"
            path = " > ".join(self.failure.nodes)
            lines.append(f"  {path}, at {seconds(self.failure.time_s)}{message}")
        lines.append(
            f"  {seconds(self.virtual_s)} in {seconds(self.wall_s)} of wall time "
            f"({self.real_time_factor:.1f} x real time), seed {self.seed}"
        )
        if self.nature:
            lines.append(f"  nature: {in_words(self.nature)}")
        facts = [f"{counted(self.goals_sent, 'goal')} sent", f"{self.goals_left_behind} orphaned"]
        if self.distance_travelled_m is not None:
            facts.append(f"{self.distance_travelled_m:.2f} m driven")
        if self.collisions is not None:
            facts.append(counted(self.collisions, "collision"))
        lines.append("  " + ", ".join(facts))
        lines += [f"  requirement {requirement}" for requirement in self.requirements]
        lines += [f"  fault {fault}" for fault in self.faults]
        named = {fault.untested for fault in self.faults}
        lines += [f"  not tested: {each}" for each in self.untested if each not in named]
        lines += [f"  warning: {warning}" for warning in self.warnings]
        return "\n".join(map(escape_control, lines))


def report_on(
    mission: Mission,
    executive: Executive,
    trace: Trace,
    virtual_s: float,
    wall_s: float,
    requirements: tuple[RequirementResult, ...] = (),
    warnings: Iterable[str] = (),
) -> Report:
    """Return the report of a mission that has ended, from its executive."""
    return Report(
        mission=mission.name,
        status=str(executive.status),
        reason=executive.reason,
        world=mission.world,
        robot=mission.robot,
        seed=mission.seed,
        virtual_s=round(virtual_s, 6),
        wall_s=round(wall_s, 3),
        real_time_factor=round(virtual_s / wall_s, 1) if wall_s > 0 else 0.0,
        ticks=executive.ticks,
        goals_sent=executive.goals_sent,
        goals_left_behind=len(executive.goals_left_behind),
        collisions=None,
        distance_travelled_m=None,
        trace_sha256=trace.sha256,
        sample=sample_of(trace, requirements),
        failure=_failure_of(executive, virtual_s),
        requirements=requirements,
        untested=tuple(executive.mission_state.untested),
        warnings=tuple(warnings),
    )


def sample_of(trace: Trace, requirements: Iterable[RequirementResult]) -> str:
    """Return 16 hexadecimal digits that are equal for two runs with the same outcome and signals.

    Events, the robot's true poses and the requirements count; the seed does not.
    """
    results = [
        (requirement.name, requirement.verdict, requirement.margin, requirement.at)
        for requirement in requirements
    ]
    content = f"{trace.seedless_sha256} {results!r}"
    return hashlib.sha256(content.encode()).hexdigest()[:16]


def _failure_of(executive: Executive, virtual_s: float) -> FailurePath | None:
    """Return the failure path of a tree whose mission ended after some seconds."""
    path = executive.mission_state.failure_path()
    if not path:
        return None
    end, infos = executive.mission_state.last_end(path[-1]), executive.node_infos
    ago_s = (executive.ended_ns - (end.time_ns or 0)) / NS
    return FailurePath(
        nodes=tuple(infos[index].name for index in path),
        path=infos[path[-1]].path,
        message=end.message,
        time_s=round(virtual_s - ago_s, 6),
    )
