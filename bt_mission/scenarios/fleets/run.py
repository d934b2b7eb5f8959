"""Runs a fleet: every mission from its start to its report."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from bt_mission.base.clock_watch import UNATTENDED_S
from bt_mission.scenarios.fleets.loader import FleetChanges, load_fleet
from bt_mission.scenarios.fleets.plan import FleetPlan
from bt_mission.scenarios.fleets.report import FleetReport, RobotReport
from bt_mission.sessions.drive import Reports, drive
from bt_mission.sessions.stage import Stage


def run_fleet(fleet: str | Path | FleetPlan, *, seed: int | None = None) -> FleetReport:
    """Run a fleet in a new simulation; return its report.

    ``assert run_fleet("two.fleet.yaml").status == "success"``

    Args:
        fleet: A file, or what `load_fleet` gives.
        seed: Instead of all seeds of the file.

    Raises:
        InputError: With every error of the file.
    """
    plan = fleet
    if not isinstance(plan, FleetPlan):
        plan = load_fleet(plan, FleetChanges(seed=seed))
    elif seed is not None:
        plan = load_fleet(plan.document, FleetChanges(seed=seed))
    with fleet_stage(plan) as stage:
        return fleet_report(plan.name, stage, drive(stage))


@contextmanager
def fleet_stage(plan: FleetPlan) -> Iterator[Stage]:
    """Put a fleet on a stage; its pictures are deleted with the stage.

    Code of users is interrupted that does not return.
    """
    options = replace(plan.stage_options, hold_limit_s=UNATTENDED_S)
    with (
        TemporaryDirectory(prefix="bt_mission_") as images,
        Stage(robots=plan.robots, image_folder=Path(images), options=options) as stage,
    ):
        stage.facts["fleet"] = plan.name
        yield stage


def fleet_report(name: str, stage: Stage, reports: Reports) -> FleetReport:
    """Return the report of a fleet, from those of its missions."""
    return FleetReport(
        fleet=name,
        world=stage.world,
        seed=stage.seed,
        virtual_s=max(report.virtual_s for report in reports),
        wall_s=max(report.wall_s for report in reports),
        robots=tuple(
            RobotReport(run.name, report, dict(run.robot.collisions_with))
            for run, report in zip(stage.runs, reports, strict=True)
        ),
    )
