"""``bt-mission run``: run a mission."""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from typing import TYPE_CHECKING

from bt_mission.base.dds.middleware import prepare_middleware
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import kind_of
from bt_mission.cli import recording
from bt_mission.cli.argument_types import seconds, unchecked_output_file
from bt_mission.cli.exits import MISSION_FAILED, SUCCESS
from bt_mission.cli.extensions import Kept, show_options, shown_around
from bt_mission.cli.options import (
    ALLOW_DUPLICATES,
    CMD_VEL_TYPE,
    EDITABLE,
    FAULT,
    IMAGES,
    JSON,
    MISSION,
    NAMESPACE,
    NETWORK,
    NO_PYTHON,
    OVERRIDES,
    PLAIN,
    REQUIRE,
    SIMULATOR,
    SPEED,
    WALL_CLOCK,
    announce,
    known_mission_file,
    mission_file,
    nature_option,
    prepare_graph,
)
from bt_mission.cli.parser import Command, Option, each, refuse_for_kind
from bt_mission.cli.run_plan import RunPlan, Summarize, Summary, load_plan, takes_faults
from bt_mission.cli.run_shown import pace, shown_on_page, shown_on_screen, with_end
from bt_mission.cli.view import VIEW, windows
from bt_mission.cli.web import stay_until_left, watching_process, web_options

if TYPE_CHECKING:
    from bt_mission.scenarios.faults.live import LiveFaults
    from bt_mission.sessions.drive import Reports
    from bt_mission.sessions.session import Session
    from bt_mission.sessions.view import View

EPILOG = """\
examples:
  bt-mission run explore                        a shipped mission, as fast as possible
  bt-mission run mine.yaml --web                your own mission, in real time, in a browser
  bt-mission run explore --set legs=2 --seed 3  other inputs, other noise
  bt-mission run explore --record explore.mcap  then: bt-mission replay explore.mcap
  bt-mission run two_wanderers                  a fleet; `bt-mission missions` lists all
  bt-mission run explore --attach               against running servers and a robot

exit codes: 0 success, or the expected result of a scenario; 1 mission failed, requirement
violated, unexpected result of a scenario, or a file that was asked for is incomplete, as on a
full disk: the summary names it; 2 bad input, 130 interrupted
"""


def _what_starts(options: argparse.Namespace) -> str:
    """What is about to run and where, by a first look at the file."""
    from bt_mission.base.files import plain_words

    try:
        file = known_mission_file(options)
    except BtMissionError:  # told when the file is read
        file = None
    words = {} if file is None else plain_words(file)
    name = words.get("fleet") or words.get("scenario") or words.get("mission") or options.file
    if options.attach:
        return f"{name}: joining the ROS graph"
    world = options.world or words.get("world")
    return f"{name} in {world}: starting" if world else f"{name}: starting"


def _plan(options: argparse.Namespace) -> RunPlan:
    """Return what the options ask to run."""
    if sys.stderr.isatty():
        announce(_what_starts(options))
    kind = kind_of(mission_file(options))
    refuse_for_kind(options, kind)
    if options.attach or options.visible or options.editable:
        prepare_graph(options)
    else:
        prepare_middleware()
    return load_plan(options, kind)


def run(options: argparse.Namespace) -> int:
    """Run the mission as the options ask, and print its summary; return the exit code.

    A run that succeeds fails if a file that was asked for is incomplete.
    """
    plan = _plan(options)
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


def _view(options: argparse.Namespace, plan: RunPlan, *, plain: bool) -> View:
    if options.json:
        from bt_mission.views.terminal.log_lines import LogLineView

        return LogLineView()
    from bt_mission.views.terminal.live_view import view_for

    return view_for(sys.stdout, plan.title, plain=plain)


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


_ON_A_GRAPH = (
    Option(
        "--attach",
        "run only the executive; the servers run in other processes",
        not_for={
            "scenario": "a scenario has its own simulation",
            "fleet": "a fleet has its own simulation; attach each robot's mission, with "
            "--namespace",
        },
    ),
    WALL_CLOCK.but(needs=each("attach", why="a simulation has its own clock")),
    NAMESPACE.but(
        help="namespace of the robot whose servers run the mission",
        needs=each("attach", why="it names a robot of a running graph"),
    ),
    Option(
        "--journal FILE",
        "save the state of the running mission to this file",
        unchecked_output_file,
        needs=each("attach", why="a simulation ends with its process"),
    ),
    Option(
        "--resume",
        "continue a mission where its process died",
        needs=each("journal"),
    ),
)

COMMANDS = {
    "run": Command(
        run,
        "Checks a mission, then runs it in a simulation as fast as possible, or with --attach "
        "against the action servers of a running ROS graph. Ctrl-C halts the mission and waits "
        "until every goal has ended and the robot has stopped; a second Ctrl-C exits at once.",
        (
            MISSION,
            REQUIRE,
            FAULT.but(
                help="inject a fault into the simulation, such as 'at 5.0: drop scan lasting 2'; "
                "in a fleet, for every robot, or for one: 'ROBOT: at 5.0: ...'; may be repeated"
            ),
            *OVERRIDES,
            SIMULATOR.but(
                excludes=each("attach", why="the robot is that of the graph"),
                not_for=each("fleet", why="another simulator moves one robot"),
            ),
            nature_option("none"),
            CMD_VEL_TYPE.but(excludes=each("attach", why="the robot is that of the graph")),
            NO_PYTHON,
            SPEED.but(
                help="simulated seconds per second; 1 is real time (default: as fast as possible)",
                excludes=each("attach", why="an attached run runs at the speed of its graph"),
            ),
            Option(
                "--observe SECONDS",
                "continue the simulation after the mission has ended, and evaluate its "
                "requirements for this time (default: as the file says)",
                seconds,
            ),
            Option(
                "--visible",
                "let other processes on this machine communicate with the simulated run",
                excludes=each("attach", why="an attached run is always visible"),
            ),
            EDITABLE.but(
                help="take new versions of the mission from `bt-mission revise` while it runs; a "
                "simulated run is then visible to other processes on this machine"
            ),
            Option(
                "--pause-before NODE",
                "pause the mission before this node starts, given by its name or a path such as "
                "0.1.0; may be repeated",
                repeats=True,
                needs=each(
                    "web",
                    "tui",
                    "visible",
                    "editable",
                    "attach",
                    why="nothing else can resume the mission",
                ),
                not_for=each("fleet", why="its missions have their own nodes"),
            ),
            *(option.but(group="on a running ROS graph") for option in _ON_A_GRAPH),
            NETWORK.but(
                needs=each(
                    "attach",
                    "visible",
                    "editable",
                    why="no other process communicates with this run otherwise",
                )
            ),
            ALLOW_DUPLICATES.but(needs=each("attach", why="a simulation is the only publisher")),
            JSON,
            PLAIN,
            Option(
                "--tui",
                "show the full-screen view of `bt-mission watch`, in real time unless --speed is "
                "given",
                excludes=each("json", "plain"),
            ),
            IMAGES.but(help="folder for the images of camera sweeps (default: images)"),
            VIEW,
            *web_options("tui"),
            *show_options(),
            *recording.RECORDING_OPTIONS,
        ),
        EPILOG,
        leaves_at_once=True,
    )
}
