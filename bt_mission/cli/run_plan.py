"""What ``bt-mission run`` carries out: a mission or a scenario, with the faults of its options."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from bt_mission.cli.check import examined_file
from bt_mission.cli.options import nature_of
from bt_mission.cli.outputs import files_of, refuse_overwritten

if TYPE_CHECKING:
    from bt_mission.executive.report import Report
    from bt_mission.faults.located import WrittenFault
    from bt_mission.language.mission import Mission
    from bt_mission.scenarios.scenario import Scenario, ScenarioResult
    from bt_mission.sessions.stage_robot import StageOptions

    AddOutcomes = AbstractContextManager[Callable[[Report], Report]]


@dataclass(frozen=True)
class RunPlan:
    """A mission, what goes wrong, and the scenario that it is of, if it is of one."""

    mission: Mission
    faults: tuple[WrittenFault, ...] = ()
    scenario: Scenario | None = None

    def stage_options(self, options: argparse.Namespace) -> StageOptions:
        """How the stage is set up."""
        from bt_mission.sessions.stage_robot import StageOptions

        own = self.scenario.stage_options if self.scenario else StageOptions()
        return replace(
            own,
            nature=nature_of(options) or own.nature,
            visible=options.visible,
            network=options.network,
            watched=options.tui or options.web or options.foxglove,
            props=_obstacles() if self.faults else own.props,
        )

    def faults_in(self, session: Any) -> AddOutcomes:
        """Have faults begin in a run on the stage; gives what adds their outcomes to its report."""
        if self.scenario is not None:
            from bt_mission.scenarios.run import stop_at

            stop_at(session, self.scenario.limit)
        if not self.faults:
            return nullcontext(lambda report: report)
        from bt_mission.faults.located import planned_on

        return planned_on(session, self.faults)

    def judge(self, report: Report) -> ScenarioResult | None:
        """Compare the result with what the scenario expects; None without a scenario."""
        return None if self.scenario is None else self.scenario.judge(report)


def load_plan(options: argparse.Namespace) -> RunPlan:
    """Load and check what the options name; warnings go to standard error.

    Raises:
        InputError: With every error.
    """
    faults = _written_faults(options)
    loaded, warnings = examined_file(options)
    for warning in warnings:
        print(warning, file=sys.stderr)
    refuse_overwritten(options, files_of(getattr(loaded, "mission", loaded)))
    if not hasattr(loaded, "mission"):
        return RunPlan(loaded, faults)
    return RunPlan(loaded.mission, (*loaded.faults, *faults), loaded)


def _written_faults(options: argparse.Namespace) -> tuple[WrittenFault, ...]:
    if not options.fault:
        return ()
    from bt_mission.faults.located import faults_in_texts

    found = faults_in_texts(options.fault)
    for doubt in (doubt for one in found for doubt in one.doubts()):
        print(doubt, file=sys.stderr)
    return found


def _obstacles() -> int:
    from bt_mission.faults.world import MOST_OBSTACLES

    return MOST_OBSTACLES
