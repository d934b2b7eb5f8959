"""Carries a fleet out: every mission from its start to its report."""

from __future__ import annotations

from contextlib import AbstractContextManager, ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Protocol, Self

from bt_mission.core.interrupts import TWO_WISHES, InterruptSignals
from bt_mission.core.stamps import NS
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.events.events import Event, LogLine, NodeChanged
from bt_mission.executive.executive import Executive
from bt_mission.executive.leaf_statistics import LeafStatistics
from bt_mission.executive.report import report_on
from bt_mission.fleets.loader import FleetChanges, load_fleet
from bt_mission.fleets.plan import FleetPlan
from bt_mission.fleets.report import FleetReport, RobotReport
from bt_mission.sessions.session import SessionViews, Steps, finish, take_steps
from bt_mission.sessions.stage import Stage
from bt_mission.sessions.stage_robot import FleetRun


class FleetView(AbstractContextManager["FleetView"], Protocol):
    """What people see while a fleet runs."""

    def open(self, stage: Stage, wall: Stopwatch, /) -> None:
        """Begin to show it."""

    def on_robot_change(self, robot: str, change: NodeChanged, /) -> None:
        """A node of a robot's mission changed its status."""

    def on_robot_line(self, robot: str, text: str, /) -> None:
        """A robot's mission says something."""

    def refresh(self) -> None:
        """Called between steps."""


class QuietFleet:
    """Shows nothing."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def open(self, _stage: Stage, _wall: Stopwatch, /) -> None:
        """Nothing to show."""

    def on_robot_change(self, _robot: str, _change: NodeChanged, /) -> None:
        """Nothing to show."""

    def on_robot_line(self, _robot: str, _text: str, /) -> None:
        """Nothing to show."""

    def refresh(self) -> None:
        """Nothing to show."""


def driving_fleet(
    stage: Stage,
    plan: FleetPlan,
    view: FleetView,
    interrupts: InterruptSignals,
    *,
    speed: float | None = None,
) -> Steps[FleetReport]:
    """Step a fleet to its end, as :func:`bt_mission.sessions.session.driving` does one mission.

    Ctrl-C halts the missions of all robots.
    """
    wall = Stopwatch()
    with ExitStack() as stack:
        stack.enter_context(interrupts)
        view.open(stage, wall)
        stack.enter_context(view)
        audience = SessionViews(view.refresh)
        statistics = [_listen(run, view, audience) for run in stage.runs]
        ends = [_WallTime(run.executive, wall) for run in stage.runs]
        executives = [run.executive for run in stage.runs]
        yield from take_steps(stage, executives, audience, interrupts, speed)
    wall_s = wall.elapsed_s
    robots = tuple(
        report_of_robot(stage, run, wall_s if end.wall_s is None else end.wall_s, leaves)
        for run, end, leaves in zip(stage.runs, ends, statistics, strict=True)
    )
    return FleetReport(
        fleet=plan.name,
        world=plan.world.name,
        seed=plan.seed,
        virtual_s=max(one.mission.virtual_s for one in robots),
        wall_s=round(wall_s, 3),
        robots=robots,
    )


def run_fleet(fleet: str | Path | FleetPlan, *, seed: int | None = None) -> FleetReport:
    """Carry a fleet out in a simulation of its own; gives what it came to.

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
    with (
        TemporaryDirectory(prefix="bt_mission_") as images,
        Stage(robots=plan.robots, image_folder=Path(images), options=plan.stage_options) as stage,
    ):
        return finish(driving_fleet(stage, plan, QuietFleet(), InterruptSignals(TWO_WISHES)))


def report_of_robot(
    stage: Stage, run: FleetRun, wall_s: float, leaves: LeafStatistics
) -> RobotReport:
    """Return what a mission that has ended came to, `wall_s` after the start of all."""
    end_ns = run.executive.ended_ns or stage.now_ns
    report = report_on(
        run.member.mission,
        run.executive,
        run.trace,
        (end_ns - stage.start_ns) / NS,
        wall_s,
        run.runner.requirements.results(),
    )
    found = replace(
        report,
        world=stage.world,
        collisions=run.robot.collisions,
        nature=run.nature,
        distance_travelled_m=round(run.robot.distance_travelled, 6),
        leaves=leaves.summaries(),
    )
    return RobotReport(run.member.name, found, dict(run.robot.collisions_with))


class _WallTime:
    """Notes when a mission of several ends, s; None where it is left before that."""

    def __init__(self, executive: Executive, wall: Stopwatch) -> None:
        self.wall_s: float | None = None
        self._executive, self._wall = executive, wall
        executive.after_tick.append(self._look)

    def _look(self) -> None:
        if self._executive.is_done:
            self.wall_s = self._wall.elapsed_s


def _listen(run: FleetRun, view: FleetView, audience: SessionViews) -> LeafStatistics:
    """Have a view told of a robot; returns what counts what its leaves do."""
    name = run.member.name

    def take(event: Event) -> None:
        match event:
            case NodeChanged():
                audience.show(lambda: view.on_robot_change(name, event))
            case LogLine(text=text):
                audience.show(lambda: view.on_robot_line(name, text))

    run.executive.events.subscribe(take)
    return LeafStatistics(run.executive, partial(_distance, run))


def _distance(run: FleetRun) -> float:
    return run.robot.distance_travelled
