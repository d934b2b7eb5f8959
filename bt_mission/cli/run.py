"""``bt-mission run``: carry a mission out."""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.cli import recording
from bt_mission.cli.argument_types import seconds, speed, unchecked_output_file
from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS
from bt_mission.cli.foxglove import add_foxglove_options, refuse_foxglove
from bt_mission.cli.network import add_duplicates_option, add_network_option, prepare_graph
from bt_mission.cli.options import (
    add_fault_option,
    add_mission_file,
    add_nature_option,
    add_overrides,
    add_plain_option,
    add_python_option,
    add_require_option,
    known_mission_file,
    mission_file,
)
from bt_mission.cli.run_plan import load_plan
from bt_mission.cli.run_shown import run_in_lines, run_on_page, run_on_screen
from bt_mission.cli.view import add_view_option, refuse_view
from bt_mission.cli.web import add_web_options, refuse_web
from bt_mission.core.dds.middleware import prepare_middleware
from bt_mission.core.errors import BtMissionError
from bt_mission.core.files import kind_of

if TYPE_CHECKING:
    from bt_mission.executive.report import Report

EPILOG = """\
examples:
  bt-mission run explore                        a shipped mission, as fast as it goes
  bt-mission run mine.yaml --web                your own, in real time, on a page for browsers
  bt-mission run explore --set legs=2 --seed 3  other inputs, other noise
  bt-mission run explore --record explore.mcap  then: bt-mission replay explore.mcap
  bt-mission run two_wanderers                  a fleet; `bt-mission missions` lists what is shipped
  bt-mission run explore --attach               against servers and a robot that run already

exit codes: 0 success, or the expected result of a scenario; 1 mission failed, requirement
violated, or another result than expected; 2 bad input, 130 interrupted. A full disk changes
none of them: the summary says what a file lacks
"""


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "run",
        description="Checks a mission, then carries it out: in a simulation of its own as fast "
        "as this machine can, or with --attach against the action servers of a running ROS "
        "graph. Ctrl-C halts the mission, sees every goal ended and the robot stopped; a second "
        "Ctrl-C leaves at once.",
        epilog=EPILOG,
    )
    add_mission_file(parser)
    add_require_option(parser)
    add_fault_option(parser)
    add_overrides(parser)
    add_nature_option(parser, "none")
    add_python_option(parser)
    parser.add_argument(
        "--speed",
        type=speed,
        help="seconds of simulation per second, 1 for real time (default: as fast as it goes)",
    )
    parser.add_argument(
        "--observe",
        type=seconds,
        metavar="SECONDS",
        help="let time go on after the mission's end, with its goals ended and the base standing, "
        "and evaluate its requirements meanwhile (default: as the file says)",
    )
    parser.add_argument(
        "--visible",
        action="store_true",
        help="let other processes of this machine see the simulated run (and be heard by it)",
    )
    _add_attach_options(parser)
    add_network_option(parser)
    add_duplicates_option(parser, "with --attach: ")
    parser.add_argument("--json", action="store_true", help="print one JSON object at the end")
    add_plain_option(parser)
    parser.add_argument(
        "--tui",
        action="store_true",
        help="the full-screen view of `bt-mission watch`; in real time unless --speed says else",
    )
    parser.add_argument(
        "--images",
        type=Path,
        default=Path("images"),
        help="where camera sweeps make their folders (default: images)",
    )
    add_view_option(parser)
    add_web_options(parser)
    add_foxglove_options(parser)
    recording.add_recording_options(parser)
    parser.set_defaults(command=run)


def _add_attach_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("on a ROS graph that runs already")
    group.add_argument(
        "--attach",
        action="store_true",
        help="run the executive alone, against servers in other processes",
    )
    group.add_argument(
        "--wall-clock",
        action="store_true",
        help="with --attach: keep to this machine's clock, without looking for /clock first",
    )
    group.add_argument(
        "--namespace",
        default="",
        help="with --attach: namespace of the robot whose servers carry the mission out",
    )
    group.add_argument(
        "--journal",
        type=unchecked_output_file,
        metavar="FILE",
        help="with --attach: write down in this file where the mission stands, as it goes",
    )
    group.add_argument(
        "--resume",
        action="store_true",
        help="with --journal: go on where a mission stood when its process died",
    )


def run(options: argparse.Namespace) -> int:
    """Run the mission; gives the exit code."""
    with leaving_at_once():
        return _run(options)


def announce(what: str) -> None:
    """Tell people at a terminal what goes on, before the imports and ROS take their seconds."""
    if sys.stderr.isatty():
        print(f"{what} ...", file=sys.stderr, flush=True)


def _what_starts(options: argparse.Namespace) -> str:
    """What is about to run and where, by a first look at the file."""
    from bt_mission.core.files import plain_words

    try:
        file = known_mission_file(options)
    except BtMissionError:  # told when the file is read
        file = None
    said = {} if file is None else plain_words(file)
    name = said.get("fleet") or said.get("scenario") or said.get("mission") or options.file
    if options.attach:
        return f"{name}: joining the ROS graph"
    world = options.world or said.get("world")
    return f"{name} in {world}: starting" if world else f"{name}: starting"


def _run(options: argparse.Namespace) -> int:
    refuse_contradictions(options)
    if sys.stderr.isatty():
        announce(_what_starts(options))
    from bt_mission.cli.watch import is_drawable
    from bt_mission.executive.status import MissionStatus

    if options.attach or options.visible:
        prepare_graph(options)
    else:
        prepare_middleware()
    if kind_of(mission_file(options)) == "fleet":
        from bt_mission.cli.run_fleet import run_fleet

        return run_fleet(options)
    plan = load_plan(options)
    if options.web and not options.attach:
        run_shown = run_on_page
    else:
        run_shown = run_on_screen if options.tui and is_drawable() else run_in_lines
    report, kept = run_shown(options, plan)
    result = plan.judge(report)
    if options.json:
        judged = {} if result is None else {"scenario": result.as_dict()}
        print(json.dumps({**report.as_dict(), **kept, **judged}))
    else:
        lines = [report.as_text(), *_leaves(report), *recording.told(kept)]
        print("\n".join(lines if result is None else [*lines, str(result)]))
    codes = {
        MissionStatus.SUCCESS: SUCCESS,
        MissionStatus.INTERRUPTED: INTERRUPTED,
        MissionStatus.FAILURE: MISSION_FAILED,
    }
    code = codes[MissionStatus(report.status)]
    if result is not None:
        is_left = code == INTERRUPTED and not result.is_whole
        return code if is_left else SUCCESS if result.passed else MISSION_FAILED
    return MISSION_FAILED if code == SUCCESS and report.is_violated else code


def _leaves(report: Report) -> list[str]:
    """What each leaf came to, for people; programs that read a pipe ask for ``--json``."""
    if not sys.stdout.isatty():
        return []
    from bt_mission.views.terminal.lines import leaf_table
    from bt_mission.views.terminal.marks import marks_for

    width = shutil.get_terminal_size().columns
    return leaf_table(report.leaves, width, marks_for(sys.stdout.encoding))


@contextmanager
def leaving_at_once() -> Iterator[None]:
    """Before a mission starts and after it has ended there is nothing to halt on Ctrl-C."""
    before = {
        number: signal.signal(number, lambda *_: os._exit(INTERRUPTED))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def refuse_contradictions(options: argparse.Namespace) -> None:
    """Refuse options that would be ignored.

    Raises:
        BtMissionError: With what to do instead.
    """
    if options.tui and (options.json or options.plain):
        raise BtMissionError("--tui: a full screen leaves no room for --json or --plain")
    refuse_web(options, instead=("tui",))
    refuse_foxglove(options)
    recording.refuse_recording(options)
    refuse_view(options)
    if options.attach and options.speed is not None:
        raise BtMissionError("--speed: an attached run has the pace of the graph that it joins")
    if options.attach and (options.world or options.robot or options.nature):
        raise BtMissionError("--world, --robot, --nature: an attached run has those of its graph")
    if options.attach and options.visible:
        raise BtMissionError("--visible: an attached run is seen anyway")
    if options.network and not (options.attach or options.visible):
        raise BtMissionError("--network goes with --attach or --visible: nobody hears another run")
    if options.allow_duplicates and not options.attach:
        raise BtMissionError("--allow-duplicates goes with --attach: a simulation is alone")
    if options.journal and not options.attach:
        raise BtMissionError("--journal goes with --attach: a simulation ends with its process")
    if options.resume and not options.journal:
        raise BtMissionError("--resume: name the journal to go on from with --journal FILE")
    if options.wall_clock and not options.attach:
        raise BtMissionError("--wall-clock goes with --attach; a simulation has a clock of its own")
