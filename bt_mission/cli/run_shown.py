"""Carrying a mission out: shown in lines, on a full screen, or to browsers."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any, TypeVar

from bt_mission.cli import recording
from bt_mission.cli.foxglove import foxglove_on
from bt_mission.cli.run_plan import RunPlan
from bt_mission.cli.view import window_on
from bt_mission.cli.web import stay_until_left, to_stderr, watching_process, web_server

if TYPE_CHECKING:
    from bt_mission.executive.report import Report
    from bt_mission.sessions.attached import AttachedSession
    from bt_mission.sessions.session import Steps, View
    from bt_mission.sessions.stage import Stage

R = TypeVar("R")


def run_in_lines(options: argparse.Namespace, plan: RunPlan) -> tuple[Report, recording.Kept]:
    """Carry the mission out, shown in lines."""
    from bt_mission.core.memory import settle_memory
    from bt_mission.executive.status import MissionStatus
    from bt_mission.sessions.session import drive

    view = _view(options)
    with (
        _open_session(options, plan, view.say) as session,
        plan.faults_in(session) as with_outcomes,
        window_on(session, wanted=options.view),
        foxglove_on(options, session),
        watching_process(options, session.node.get_fully_qualified_name()),
        recording.recorder_for(options, session) as keeping,
    ):
        settle_memory()
        report = with_outcomes(drive(session, view, speed=pace(options)))
        _tell_resumable(options, session)
        kept = keeping.finish(report)
        if options.web and report.status != MissionStatus.INTERRUPTED:
            stay_until_left(report.status)
        return report, kept


def _view(options: argparse.Namespace, *, plain: bool = False) -> View:
    if options.json:
        from bt_mission.views.terminal.quiet import Quiet

        return Quiet()
    from bt_mission.views.terminal.views import view_for

    return view_for(sys.stdout, plain=plain or options.plain)


def run_on_screen(options: argparse.Namespace, plan: RunPlan) -> tuple[Report, recording.Kept]:
    """Carry the mission out on a full screen, in real time unless another speed is asked for."""
    from contextlib import closing

    from bt_mission.core.interrupts import TWO_WISHES, InterruptSignals
    from bt_mission.core.memory import settle_memory
    from bt_mission.ros.discovery import LocalExecutive
    from bt_mission.sessions.session import driving
    from bt_mission.views.terminal.marks import marks_for
    from bt_mission.views.terminal.quiet import Quiet
    from bt_mission.views.tui.run_app import RunApp

    with (
        _open_session(options, plan, lambda _: None) as session,
        plan.faults_in(session) as with_outcomes,
        closing(LocalExecutive(session)) as graph,
        window_on(session, wanted=options.view),
        foxglove_on(options, session),
        recording.recorder_for(options, session) as keeping,
    ):
        interrupts = InterruptSignals(TWO_WISHES)
        steps = driving(session, Quiet(), interrupts, speed=pace(options))
        marks = marks_for(sys.stdout.encoding)
        settle_memory()
        report = with_outcomes(RunApp(graph, marks, graph.name, steps, interrupts).run_to_the_end())
        _tell_resumable(options, session)
        return report, keeping.finish(report)


def run_on_page(options: argparse.Namespace, plan: RunPlan) -> tuple[Report, recording.Kept]:
    """Carry the mission out in the simulation, shown to browsers."""
    from contextlib import closing

    from bt_mission.core.interrupts import TWO_WISHES, InterruptSignals
    from bt_mission.ros.discovery import LocalExecutive
    from bt_mission.sessions.session import StepDriver, driving
    from bt_mission.views.web.live import LiveMission
    from bt_mission.views.web.run import ENDED, ShownRun

    view = _view(options, plain=True)
    with (
        # Also while it starts, and while the page stays.
        InterruptSignals(TWO_WISHES) as interrupts,
        _open_session(options, plan, view.say) as session,
        plan.faults_in(session) as with_outcomes,
        closing(LocalExecutive(session)) as graph,
        window_on(session, wanted=options.view),
        foxglove_on(options, session),
        recording.recorder_for(options, session) as keeping,
    ):
        kept: recording.Kept = {}

        def end(report: Report) -> Report:
            judged = with_outcomes(report)
            kept.update(keeping.finish(judged))
            return judged

        steps = driving(session, view, interrupts, speed=pace(options))
        driver = StepDriver(ending(steps, end))

        def is_left() -> bool:
            return driver.report is not None and interrupts.count > 0

        shown = LiveMission(graph, graph.name, lambda: ENDED if driver.report else "")
        shown.attach(graph.name)  # before the first step, so that nothing is missed
        with web_server(options, shown, is_fast=(pace(options) or 0.0) > 1.0) as server:
            report = ShownRun(server, driver, is_left, to_stderr).run_to_the_end()
        return report, kept


def ending(steps: Steps[R], end: Callable[[R], R]) -> Steps[R]:
    """Step to the end, and do at once what is due there, since the page may stay for long."""
    report = yield from steps
    return end(report)


def _tell_resumable(options: argparse.Namespace, session: Any) -> None:
    if options.journal and session.executive.is_resumable:
        print(f"to go on with it: --journal {options.journal} --resume", file=sys.stderr)


def pace(options: argparse.Namespace) -> float | None:
    """What people look at is in real time, unless they want another speed."""
    is_shown = options.tui or options.view or options.web or options.foxglove
    return options.speed or (1.0 if is_shown and not options.attach else None)


def _open_session(options: argparse.Namespace, plan: RunPlan, say: Any) -> AttachedSession | Stage:
    if options.attach:
        from bt_mission.sessions.attached import AttachedOptions, AttachedSession

        joining = AttachedOptions(
            namespace=options.namespace,
            wall_clock=options.wall_clock,
            allow_duplicates=options.allow_duplicates,
            journal=options.journal,
            resume=options.resume,
        )
        return AttachedSession(plan.mission, joining, say)
    from bt_mission.sessions.stage import Stage

    with plan.scenario.at_its_start() if plan.scenario else nullcontext():
        return Stage(
            plan.mission,
            image_folder=options.images,
            say=say,
            options=plan.stage_options(options),
        )
