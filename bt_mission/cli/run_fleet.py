"""``bt-mission run`` of a fleet: several robots in one simulation, each with its mission."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from contextlib import ExitStack, closing
from typing import TYPE_CHECKING, Any

from bt_mission.cli import recording
from bt_mission.cli.check import examined_fleet
from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS
from bt_mission.cli.foxglove import foxglove_on
from bt_mission.cli.outputs import file_of_robot, files_of, refuse_existing, refuse_overwritten
from bt_mission.cli.view import window_on
from bt_mission.cli.web import to_stderr, web_server

if TYPE_CHECKING:
    from bt_mission.fleets.plan import FleetPlan
    from bt_mission.fleets.report import FleetReport
    from bt_mission.fleets.run import FleetView
    from bt_mission.sessions.session import Steps
    from bt_mission.sessions.stage import Stage


def run_fleet(options: argparse.Namespace) -> int:
    """Run the fleet that the options name; gives the exit code."""
    plan = load_fleet_plan(options)
    report = _run(options, plan)
    if report.status == "interrupted":
        return INTERRUPTED
    return SUCCESS if report.status == "success" and not report.is_violated else MISSION_FAILED


def load_fleet_plan(options: argparse.Namespace) -> FleetPlan:
    """Load and check the fleet; warnings go to standard error.

    Raises:
        InputError: With every error.
        BtMissionError: For options that a fleet does not take.
    """
    plan, warnings = examined_fleet(options)
    for warning in warnings:
        print(warning, file=sys.stderr)
    refuse_overwritten(options, (path for robot in plan.robots for path in files_of(robot.mission)))
    if options.trace and not options.force:
        refuse_existing(file_of_robot(options.trace, one.name) for one in plan.robots)
    fleet: FleetPlan = plan
    return fleet


def _print(options: argparse.Namespace, report: FleetReport, kept: recording.Kept) -> None:
    if options.json:
        text = json.dumps({**report.as_dict(), **kept})
    else:
        text = "\n".join([report.as_text(), *_leaves(report), *recording.told(kept)])
    print(text, flush=True)


def _run(options: argparse.Namespace, plan: FleetPlan) -> FleetReport:
    from bt_mission.cli.run_shown import ending, pace
    from bt_mission.cli.watch import is_drawable
    from bt_mission.core.interrupts import TWO_WISHES, InterruptSignals
    from bt_mission.core.memory import settle_memory
    from bt_mission.fleets.run import driving_fleet
    from bt_mission.sessions.session import finish

    on_screen = options.tui and is_drawable()
    view = _view(options, plan, on_screen=on_screen)
    interrupts = InterruptSignals(TWO_WISHES)
    with ExitStack() as stack:
        if options.web:  # also while it starts, and while the page stays
            stack.enter_context(interrupts)
        stage = stack.enter_context(_stage(options, plan))
        stack.enter_context(window_on(stage, wanted=options.view))
        stack.enter_context(foxglove_on(options, stage))
        keeping = stack.enter_context(recording.recorder_for(options, stage))
        steps = driving_fleet(stage, plan, view, interrupts, speed=pace(options))
        settle_memory()
        if options.web:
            kept: recording.Kept = {}

            def end(report: FleetReport) -> FleetReport:
                kept.update(keeping.finish(report))
                return report

            report = _on_page(options, stage, ending(steps, end), interrupts)
        else:
            report = _on_screen(stage, steps, interrupts) if on_screen else finish(steps)
            kept = keeping.finish(report)
        # Before the stage is taken down: of 16 robots that takes seconds.
        _print(options, report, kept)
        return report


def _stage(options: argparse.Namespace, plan: FleetPlan) -> Stage:
    from dataclasses import replace

    from bt_mission.cli.options import nature_of
    from bt_mission.sessions.stage import Stage

    return Stage(
        robots=plan.robots,
        image_folder=options.images,
        say=lambda _: None,  # the view hears of it robot by robot
        options=replace(
            plan.stage_options,
            nature=nature_of(options),
            visible=options.visible,
            network=options.network,
            watched=options.tui or options.web or options.foxglove,
        ),
    )


def _view(options: argparse.Namespace, plan: FleetPlan, *, on_screen: bool) -> FleetView:
    from bt_mission.fleets.run import QuietFleet

    if on_screen:
        return QuietFleet()
    from bt_mission.views.terminal.fleet import FleetSpeech, fleet_view_for

    if options.json:
        return FleetSpeech()
    return fleet_view_for(sys.stdout, plan, plain=options.plain or options.web)


def _on_screen(stage: Stage, steps: Steps[FleetReport], interrupts: Any) -> FleetReport:
    """Carry it out on a full screen, which shows one robot's mission at a time."""
    from bt_mission.ros.discovery import LocalExecutive
    from bt_mission.views.terminal.marks import marks_for
    from bt_mission.views.tui.run_app import RunApp

    with closing(LocalExecutive(stage, _names(stage))) as graph:
        app = RunApp(graph, marks_for(sys.stdout.encoding), graph.name, steps, interrupts)
        return app.run_to_the_end()


def _on_page(
    options: argparse.Namespace,
    stage: Stage,
    steps: Steps[FleetReport],
    interrupts: Any,
) -> FleetReport:
    """Carry it out shown to browsers, one robot's mission at a time."""
    from bt_mission.cli.run_shown import pace
    from bt_mission.ros.discovery import LocalExecutive
    from bt_mission.sessions.session import StepDriver
    from bt_mission.views.web.live import LiveMission
    from bt_mission.views.web.run import ENDED, ShownRun

    with closing(LocalExecutive(stage, _names(stage))) as graph:
        driver = StepDriver(steps)

        def is_left() -> bool:
            return driver.report is not None and interrupts.count > 0

        shown = LiveMission(
            graph,
            graph.name,
            lambda: ENDED if driver.report else "",
            is_fleet=len(stage.runs) > 1,
        )
        shown.attach(graph.name)  # before the first step, so that nothing is missed
        with web_server(options, shown, is_fast=(pace(options) or 0.0) > 1.0) as server:
            return ShownRun(server, driver, is_left, to_stderr).run_to_the_end()


def _names(stage: Stage) -> list[str]:
    return [run.node.get_fully_qualified_name() for run in stage.runs]


def _leaves(report: FleetReport) -> list[str]:
    """What each leaf of each robot came to, for people; as `run` tells of one mission."""
    if not sys.stdout.isatty():
        return []
    from bt_mission.views.terminal.lines import leaf_table
    from bt_mission.views.terminal.marks import marks_for

    width, marks = shutil.get_terminal_size().columns, marks_for(sys.stdout.encoding)
    lines = []
    for one in report.robots:
        table = leaf_table(one.mission.leaves, width, marks)
        lines += [f"  {one.robot}", *table] if table else []
    return lines
