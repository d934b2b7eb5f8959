"""Runs a plan, shown in lines, on a full screen, or in browsers."""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Callable
from contextlib import ExitStack, closing
from functools import partial
from typing import TYPE_CHECKING, TypeVar

from bt_mission.cli import recording
from bt_mission.cli.additions import Kept, shown_around, shown_by
from bt_mission.cli.exits import MISSION_FAILED, SUCCESS
from bt_mission.cli.run_plan import RunPlan, Summarize, Summary, takes_faults
from bt_mission.cli.view import windows
from bt_mission.cli.web import stay_until_left, to_stderr, watching_process, web_server

if TYPE_CHECKING:
    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.scenarios.faults.live import LiveFaults
    from bt_mission.sessions.drive import Reports, Steps
    from bt_mission.sessions.session import Session
    from bt_mission.sessions.view import View
    from bt_mission.views.web.run import Outcome

R = TypeVar("R")
Ended = TypeVar("Ended", bound="Outcome")


def carry_out(options: argparse.Namespace, plan: RunPlan) -> int:
    """Run a plan as the options ask, and print its summary; return the exit code.

    A run that succeeds fails if a file that was asked for is incomplete.
    """
    from bt_mission.base.interrupts import TWO_WISHES, InterruptSignals
    from bt_mission.base.memory import settle_memory
    from bt_mission.cli.screen import is_drawable
    from bt_mission.sessions.drive import driving, finish

    on_page = options.web and not options.attach
    on_screen = options.tui and is_drawable()
    interrupts = InterruptSignals(TWO_WISHES)
    with ExitStack() as stack:
        if on_page:  # also while it starts, and while the page stays
            stack.enter_context(interrupts)
        session = stack.enter_context(plan.open(options))
        for node in options.pause_before:
            session.executive.breakpoints.add(node)
        live = _live_faults(options, session)
        summarize = stack.enter_context(plan.preparing(session, live))
        stack.enter_context(shown_around(options, session))
        if not on_page:
            name = session.node.get_fully_qualified_name()
            stack.enter_context(watching_process(options, name))
        files = stack.enter_context(recording.recorder_for(options, session))
        onlookers = [*windows(session, wanted=options.view)]
        if not on_screen:
            onlookers.append(_view(options, plan, plain=options.plain or on_page))
        kept: Kept = {}
        end = _ending(options, session, summarize, files, kept)
        if session.watch is not None:
            say_end = partial(_print_last, options, plan, session, end, kept)
            session.watch.last_words.append(say_end)
        steps = with_end(driving(session, onlookers, interrupts, speed=pace(options)), end)
        settle_memory()
        if on_page:
            summary = shown_on_page(options, session, steps, interrupts, pace(options), live=live)
        elif on_screen:
            summary = shown_on_screen(session, steps, interrupts)
        else:
            summary = finish(steps)
            if options.web and summary.status != "interrupted":
                stay_until_left(summary.verdict)
        # Before the session is taken down: of 16 robots that takes seconds.
        _print(options, plan, summary, kept)
        return plan.exit_code(summary) or (MISSION_FAILED if files.is_incomplete(kept) else SUCCESS)


def _live_faults(options: argparse.Namespace, session: Session) -> LiveFaults | None:
    """Return what makes the faults of viewers, of a robot alone in a simulation."""
    if not takes_faults(options) or len(session.runs) > 1:
        return None
    from bt_mission.scenarios.faults.live import LiveFaults
    from bt_mission.sessions.stage import Stage

    return LiveFaults(session) if isinstance(session, Stage) else None


def _ending(
    options: argparse.Namespace,
    session: Session,
    summarize: Summarize,
    files: recording.RunFiles,
    kept: Kept,
) -> Callable[[Reports], Summary]:
    """Return what is due at the end of the run; a page may stay for long after it."""

    def end(reports: Reports) -> Summary:
        summary = summarize(reports)
        if options.journal and session.executive.is_resumable:
            print(f"to continue it: --journal {options.journal} --resume", file=sys.stderr)
        kept.update(files.finish(summary))
        return summary

    return end


def with_end(steps: Steps[Reports], end: Callable[[Reports], R]) -> Steps[R]:
    """Return the steps of a session with a result of its reports."""
    reports = yield from steps
    return end(reports)


def _view(options: argparse.Namespace, plan: RunPlan, *, plain: bool) -> View:
    if options.json:
        from bt_mission.views.terminal.speech import Speech

        return Speech()
    from bt_mission.views.terminal.views import view_for

    return view_for(sys.stdout, plan.title, plain=plain)


def shown_on_screen(session: Session, steps: Steps[R], interrupts: InterruptSignals) -> R:
    """Run it on a full screen, which shows one mission at a time."""
    from bt_mission.ros.local_client import LocalExecutive
    from bt_mission.views.terminal.marks import marks_for
    from bt_mission.views.tui.run_app import RunApp

    with closing(LocalExecutive(session)) as graph:
        marks = marks_for(sys.stdout.encoding)
        app = RunApp(graph, marks, graph.name, steps, interrupts, session.watch)
        return app.run_to_the_end()


def shown_on_page(
    options: argparse.Namespace,
    session: Session,
    steps: Steps[Ended],
    interrupts: InterruptSignals,
    speed: float | None,
    until_ns: int = 0,
    live: LiveFaults | None = None,
) -> Ended:
    """Run a session shown to browsers, one mission at a time.

    The page is served from `until_ns` on, an instant of ROS time, and shows what was before.

    Args:
        live: Makes the faults that pages ask for.
    """
    from bt_mission.ros.local_client import LocalExecutive
    from bt_mission.sessions.drive import StepDriver
    from bt_mission.views.web.live import LiveMission, OpenPanels
    from bt_mission.views.web.run import ENDED, ShownRun

    driver = StepDriver(steps)

    def is_left() -> bool:
        return driver.result is not None and interrupts.count > 0

    with closing(LocalExecutive(session)) as graph:
        shown = LiveMission(
            graph,
            graph.name,
            lambda: ENDED if driver.result else "",
            is_fleet=len(session.runs) > 1,
            faults=live,
        )
        shown.attach(graph.name)  # before the first step, so that nothing is missed
        while session.now_ns < until_ns and not driver.is_over:
            driver.advance()
            shown.look(OpenPanels())
        if driver.is_over:
            return driver.finish()
        with web_server(options, shown, is_fast=(speed or 0.0) > 1.0) as server:
            return ShownRun(server, driver, is_left, to_stderr).run_to_the_end()


def pace(options: argparse.Namespace) -> float | None:
    """Views show the run in real time, unless the options give another speed."""
    is_shown = options.tui or options.view or options.web or shown_by(options)
    return options.speed or (1.0 if is_shown and not options.attach else None)


def _print(options: argparse.Namespace, plan: RunPlan, summary: Summary, kept: Kept) -> None:
    result = plan.judge(summary)
    if options.json:
        judged = {} if result is None else {"scenario": result.as_dict()}
        import json

        print(json.dumps({**summary.as_dict(), **kept, **judged}), flush=True)
        return
    lines = [summary.as_text(), *_leaves(summary), *recording.file_lines(kept)]
    print("\n".join(lines if result is None else [*lines, str(result)]), flush=True)


def _print_last(
    options: argparse.Namespace,
    plan: RunPlan,
    session: Session,
    end: Callable[[Reports], Summary],
    kept: Kept,
) -> None:
    """Save the files and print the summary of a run that a callback does not let end."""
    _print(options, plan, end(session.reports()), kept)


def _leaves(summary: Summary) -> list[str]:
    """A table of the leaves, for people; programs that read a pipe ask for ``--json``."""
    if not sys.stdout.isatty():
        return []
    from bt_mission.views.terminal.lines import leaf_table
    from bt_mission.views.terminal.marks import marks_for

    width, marks = shutil.get_terminal_size().columns, marks_for(sys.stdout.encoding)
    lines = []
    for robot, report in summary.missions.items():
        table = leaf_table(report.leaves, width, marks)
        lines += [f"  {robot}", *table] if table and robot else table
    return lines
