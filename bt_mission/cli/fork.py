"""``bt-mission fork``: what would have become of a recorded run with a change in the middle."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.cli import recording
from bt_mission.cli.argument_types import assignment, seconds
from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS
from bt_mission.cli.options import add_fault_option, add_require_option
from bt_mission.cli.run import announce, leaving_at_once

if TYPE_CHECKING:
    from bt_mission.recording.forks.change import Change
    from bt_mission.recording.forks.fork import ForkResult
    from bt_mission.recording.forks.source import ForkSource

EPILOG = """\
examples:
  bt-mission run square --record run.mcap
  bt-mission fork run.mcap --at 12.3 --set speed=0.1    slower from then on
  bt-mission fork run.mcap --at 12.3 --mission edited.yaml --record better.mcap
  bt-mission fork run.mcap --at 12.3 --fault 'at 13: drop scan lasting 2'
  bt-mission fork run.mcap --at 12.3                    does the same happen again?

exit codes: 0 the forked mission succeeded and no requirement is violated (without a change: the
same happened again), 1 it did not, 2 bad input, or not the same up to the fork, 130 interrupted
"""


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "fork",
        help="run a recorded run again up to an instant, and on from there with a change",
        description="Runs a recorded simulation again from its start, with all that the recording "
        "holds of it: mission, world, robot, seed, inputs. What happens is compared with the "
        "recorded trace, byte by byte, up to the control step at --at. There the change takes "
        "effect, and the run goes on. The files on the disk are not used.",
        epilog=EPILOG,
    )
    parser.add_argument("file", type=Path, help="made by bt-mission run --record")
    parser.add_argument(
        "--at",
        type=partial(seconds, expected="seconds from 0, such as 12.5"),
        required=True,
        metavar="S",
        help="fork so many seconds after the mission's start, at the next control step",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        type=assignment,
        help="give a variable of the mission another value there; may be repeated",
    )
    parser.add_argument(
        "--mission",
        type=Path,
        metavar="FILE",
        help="go on as this version of the mission's file says: nodes that begin from there on "
        "begin as it has them",
    )
    add_require_option(parser)
    add_fault_option(parser)
    parser.add_argument(
        "--import-python",
        action="store_true",
        help="import the mission's Python leaves from this folder, which runs their code",
    )
    parser.add_argument(
        "--trace", type=Path, help="write what happened to this file, as JSON lines"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    recording.add_recording_options(parser)
    parser.set_defaults(command=fork, attach=False)


def fork(options: argparse.Namespace) -> int:
    """Fork the run; gives the exit code."""
    with leaving_at_once():
        return _fork(options)


def _fork(options: argparse.Namespace) -> int:
    recording.refuse_recording(options)
    announce(f"running {options.file} again")
    from bt_mission.core.dds.middleware import prepare_middleware

    prepare_middleware()
    from bt_mission.language.permissions import ANYTHING
    from bt_mission.recording.forks.change import Change, values_of
    from bt_mission.recording.forks.edit import edited
    from bt_mission.recording.forks.source import NO_PYTHON, read_source
    from bt_mission.views.terminal.forks import told

    permissions = ANYTHING if options.import_python else NO_PYTHON
    source = read_source(options.file, permissions)
    for line in source.differences:
        print(f"{options.file}: {line}", file=sys.stderr)
    change = Change()
    if options.mission is not None:
        change = edited(source, options.mission, permissions)
    given = values_of(change.mission_of(source.mission), options.set)
    change = replace(change, values={**change.values, **given}, faults=tuple(options.fault))
    step_ns = source.step_at(options.at)
    result, kept = run_fork(options, source, change, step_ns)
    if options.json:
        print(json.dumps({**result.as_dict(), "asked_at": options.at, **kept}))
    else:
        print("\n".join([*told(result, options.at), *recording.told(kept)]))
    if result.report.status == "interrupted":
        return INTERRUPTED
    is_well = result.difference is None if change.is_none else result.is_success
    return SUCCESS if is_well else MISSION_FAILED


def run_fork(
    options: argparse.Namespace, source: ForkSource, change: Change, step_ns: int
) -> tuple[ForkResult, recording.Kept]:
    """Run a recorded run again with a change, and keep it as the options ask for.

    Raises:
        BtMissionError: Where it is not the same up to the fork, or a file cannot be written.
    """
    from bt_mission.recording.forks.stage import forked_stage
    from bt_mission.sessions.session import drive
    from bt_mission.views.terminal.views import Quiet

    with (
        forked_stage(source, change, step_ns, require=options.require) as (stage, finish),
        recording.recorder_for(options, stage) as keeping,
    ):
        result = finish(drive(stage, Quiet(), trace_file=options.trace))
        return result, keeping.finish(result.report)
