"""Plans of ``bt-mission run``: a mission, a scenario or a fleet, with faults."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

from bt_mission.cli.checked import examined_file, examined_fleet, permissions_of
from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS
from bt_mission.cli.extensions import shown_by
from bt_mission.cli.options import nature_of, simulator_of
from bt_mission.cli.outputs import file_of_robot, files_of, refuse_existing, refuse_overwritten

if TYPE_CHECKING:
    from bt_mission.executive.report import Report
    from bt_mission.language.mission import Mission
    from bt_mission.scenarios.faults.live import LiveFaults
    from bt_mission.scenarios.faults.planned import PlannedFault
    from bt_mission.scenarios.fleets.plan import FleetPlan
    from bt_mission.scenarios.scenario import Scenario, ScenarioResult
    from bt_mission.sessions.drive import Reports
    from bt_mission.sessions.session import Session
    from bt_mission.sessions.stage import Stage
    from bt_mission.sessions.stage_robot import StageOptions

Summarize: TypeAlias = "Callable[[Reports], Summary]"
"""Returns the summary of a run, of the reports of its missions."""


class Summary(Protocol):
    """The summary of a run: of a mission alone, or of a fleet."""

    @property
    def status(self) -> str:
        """``success``, ``failure`` or ``interrupted``."""

    @property
    def verdict(self) -> str:
        """The status, or if that is success, the verdict of a requirement that fails."""

    @property
    def passed(self) -> bool:
        """Has every mission succeeded, and does no requirement fail?"""

    @property
    def missions(self) -> Mapping[str, Report]:
        """The report of each mission, by the name of its robot."""

    def as_dict(self) -> dict[str, Any]:
        """The fields by name, ready for JSON."""

    def as_text(self) -> str:
        """A few lines for people."""


@dataclass(frozen=True)
class MissionPlan:
    """A mission, what goes wrong, and the scenario that it is of, if it is of one."""

    mission: Mission
    faults: tuple[PlannedFault, ...] = ()
    scenario: Scenario | None = None
    title = ""

    def open(self, options: argparse.Namespace) -> Session:
        """Put the mission on the stage, or attach it to the graph."""
        if options.attach:
            from bt_mission.sessions.attached import AttachedOptions, AttachedSession

            joining = AttachedOptions(
                namespace=options.namespace,
                wall_clock=options.wall_clock,
                allow_duplicates=options.allow_duplicates,
                journal=options.journal,
                resume=options.resume,
                editable=options.editable,
                permissions=permissions_of(options),
            )
            return AttachedSession(self.mission, joining, _unsaid)
        from bt_mission.sessions.stage import Stage
        from bt_mission.sessions.stage_robot import StageOptions

        own = self.scenario.stage_options if self.scenario else StageOptions()
        chosen = _stage_options(options, own, self.faults)
        with self.scenario.at_its_start() if self.scenario else nullcontext():
            return Stage(self.mission, image_folder=options.images, say=_unsaid, options=chosen)

    def preparing(
        self, session: Any, live: LiveFaults | None = None
    ) -> AbstractContextManager[Summarize]:
        """Have the faults and the scenario's end begin at their times.

        Args:
            live: Makes the faults of viewers.
        """
        if self.scenario is not None:
            from bt_mission.scenarios.run import attend

            attend(session, self.scenario)
        return with_faults(session, self.faults, lambda reports: reports[0], live)

    def judge(self, summary: Any) -> ScenarioResult | None:
        """Compare the report with what the scenario expects; None without a scenario."""
        return None if self.scenario is None else self.scenario.judge(summary)

    def exit_code(self, summary: Summary) -> int:
        """The exit code of the command."""
        result, code = self.judge(summary), _exit_code(summary)
        if result is None or (code == INTERRUPTED and not result.is_whole):
            return code
        return SUCCESS if result.passed else MISSION_FAILED


@dataclass(frozen=True)
class FleetRunPlan:
    """A fleet, each robot with its mission, and what goes wrong."""

    fleet: FleetPlan
    faults: tuple[PlannedFault, ...] = ()

    @property
    def title(self) -> str:
        """Name, world and number of robots."""
        return self.fleet.title

    def open(self, options: argparse.Namespace) -> Stage:
        """Put the robots on the stage."""
        from bt_mission.sessions.stage import Stage

        return Stage(
            robots=self.fleet.robots,
            image_folder=options.images,
            say=_unsaid,
            options=_stage_options(options, self.fleet.stage_options, self.faults),
        )

    def preparing(
        self, session: Any, _live: LiveFaults | None = None
    ) -> AbstractContextManager[Summarize]:
        """Have the faults begin at their times; viewers make none."""
        session.facts["fleet"] = self.fleet.name
        from bt_mission.scenarios.fleets.run import fleet_report

        return with_faults(
            session, self.faults, lambda reports: fleet_report(self.fleet.name, session, reports)
        )

    def judge(self, _summary: Summary) -> None:
        """A fleet is of no scenario."""

    def exit_code(self, summary: Summary) -> int:
        """The exit code of the command."""
        return _exit_code(summary)


RunPlan: TypeAlias = MissionPlan | FleetRunPlan


def load_plan(options: argparse.Namespace, kind: str) -> RunPlan:
    """Load and check what the options name; warnings go to standard error.

    Args:
        kind: Of the file: mission, scenario or fleet.

    Raises:
        InputError: With every error.
    """
    if kind == "fleet":
        fleet, warnings = examined_fleet(options)
        _begin(options, warnings, (robot.mission for robot in fleet.robots))
        if options.trace and not options.force:
            refuse_existing(file_of_robot(options.trace, robot.name) for robot in fleet.robots)
        return FleetRunPlan(
            fleet, written_faults(options, [member.name for member in fleet.robots])
        )
    faults = written_faults(options)
    loaded, warnings = examined_file(options)
    mission = getattr(loaded, "mission", loaded)
    _begin(options, warnings, [mission])
    if mission is loaded:
        return MissionPlan(mission, faults)
    return MissionPlan(mission, (*loaded.faults, *faults), loaded)


def _begin(
    options: argparse.Namespace, warnings: Iterable[object], missions: Iterable[Mission]
) -> None:
    """Print warnings, and refuse to overwrite what is read."""
    for warning in warnings:
        print(warning, file=sys.stderr)
    refuse_overwritten(options, _files(missions))


def _files(missions: Iterable[Mission]) -> Iterator[Any]:
    for mission in missions:
        yield from files_of(mission)


def written_faults(
    options: argparse.Namespace, robots: Sequence[str] = ()
) -> tuple[PlannedFault, ...]:
    """Return the faults of ``--fault``; doubts about them go to standard error."""
    if not options.fault:
        return ()
    from bt_mission.scenarios.faults.located import faults_in_texts

    faults = faults_in_texts(options.fault, robots)
    for doubt in (doubt for fault in faults for doubt in fault.doubts()):
        print(doubt, file=sys.stderr)
    return faults


def _stage_options(
    options: argparse.Namespace, own: StageOptions, faults: Sequence[PlannedFault]
) -> StageOptions:
    return replace(
        own,
        nature=nature_of(options) or own.nature,
        simulator=simulator_of(options) or own.simulator,
        command_type=options.cmd_vel_type,
        visible=options.visible or options.editable,
        editable=options.editable,
        network=options.network,
        watched=bool(shown_by(options)),
        props=most_obstacles() if faults or takes_faults(options) else own.props,
    )


def takes_faults(options: argparse.Namespace) -> bool:
    """Return whether viewers of a simulated run can make faults."""
    return bool(options.web and not options.read_only and not options.attach)


def most_obstacles() -> int:
    """Return how many objects faults can place."""
    from bt_mission.scenarios.faults.world import MOST_OBSTACLES

    return MOST_OBSTACLES


def _exit_code(summary: Summary) -> int:
    if summary.status == "interrupted":
        return INTERRUPTED
    return SUCCESS if summary.passed else MISSION_FAILED


@contextmanager
def with_faults(
    session: Any,
    faults: Sequence[PlannedFault],
    summarize: Summarize,
    live: LiveFaults | None = None,
) -> Iterator[Summarize]:
    """Have faults begin in a session; gives what makes its summary, with what became of them."""
    if not faults:
        yield summarize
        return
    from bt_mission.scenarios.faults.located import planned_on

    with planned_on(session, faults, live.target if live else None) as with_outcomes:
        yield lambda reports: summarize(
            tuple(
                with_outcomes(report, run.name)
                for run, report in zip(session.runs, reports, strict=True)
            )
        )


def _unsaid(_text: str) -> None:
    """Views show what missions say."""
