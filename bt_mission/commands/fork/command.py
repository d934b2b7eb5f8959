"""``bt-mission fork``: what would have become of a recorded run with a change in the middle."""

from __future__ import annotations

import argparse
import json
import shlex
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import replace
from itertools import count as count_up
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.base.errors import BtMissionError
from bt_mission.base.file_kinds import MISSIONS
from bt_mission.base.interrupts import InterruptSignals
from bt_mission.base.python_process import python_command, python_environment
from bt_mission.cli import recording
from bt_mission.cli.argument_types import input_file
from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS
from bt_mission.cli.extensions import Kept, ReplayAddition
from bt_mission.cli.options import (
    AT,
    FAULT,
    JSON,
    RECORDING,
    REQUIRE,
    SET,
    SPEED,
    announce,
    recorded_robot,
)
from bt_mission.cli.parser import Command, Option, each, refuse_for_kind
from bt_mission.cli.web import web_options

if TYPE_CHECKING:
    from bt_mission.cli.run_plan import Summary
    from bt_mission.commands.fork.change import ForkChange
    from bt_mission.commands.fork.fork import ForkResult
    from bt_mission.commands.fork.source import ForkSource
    from bt_mission.executive.report import Report
    from bt_mission.recording.replay.timeline import Timeline
    from bt_mission.sessions.drive import Reports

EPILOG = """\
examples:
  bt-mission run square --record run.mcap
  bt-mission fork run.mcap --at 12.3 --set speed=0.1    slower from then on
  bt-mission fork run.mcap --at 12.3 --mission edited.yaml --record better.mcap
  bt-mission fork run.mcap --at 12.3 --fault 'at 13: drop scan lasting 2'
  bt-mission fork run.mcap --at 12.3                    check that the run repeats exactly
  bt-mission fork two.mcap --at 5 --robot burger1 --set speed=0.1    one robot of a fleet

exit codes: 0 the forked mission succeeded and no requirement is violated (without a change: the
run repeated exactly), 1 otherwise, or with an incomplete file, 2 bad input, or a difference before
the fork, 130 interrupted
"""


def fork(options: argparse.Namespace) -> int:
    """Fork the run; gives the exit code."""
    if options.at is None:
        raise BtMissionError("give the instant with --at S", code="BT-1102")
    announce(f"running {options.file} again")
    from bt_mission.base.dds.middleware import prepare_middleware

    prepare_middleware()
    from bt_mission.commands.fork.change import ForkChange, values_of
    from bt_mission.commands.fork.edit import edited
    from bt_mission.commands.fork.source import NO_PYTHON, read_source
    from bt_mission.commands.fork.terminal import fork_lines
    from bt_mission.language.permissions import ANYTHING

    permissions = ANYTHING if options.import_python else NO_PYTHON
    source = read_source(options.file, permissions, options.robot)
    has_change = options.set or options.mission or options.fault or options.require
    if source.others and has_change and not options.robot:
        raise BtMissionError(
            f"{options.file}: name the robot to change with --robot: {', '.join(source.names)}",
            code="BT-1102",
        )
    for line in source.differences:
        print(f"{options.file}: {line}", file=sys.stderr)
    if source.others:
        refuse_for_kind(options, "fleet")
    change, step_ns = ForkChange(), source.step_at(options.at)
    if options.mission is not None:
        change = edited(source, options.mission, permissions, step_ns)
    given = values_of(change.mission_of(source.mission_at(step_ns)), options.set)
    change = replace(change, values={**change.values, **given}, faults=tuple(options.fault))
    result, kept, is_whole = run_fork(options, source, change, step_ns)
    if options.json:
        print(json.dumps({**result.as_dict(), "asked_at": options.at, **kept}))
    else:
        print("\n".join([*fork_lines(result, options.at), *recording.file_lines(kept)]))
    if result.report.status == "interrupted":
        return INTERRUPTED
    is_well = result.is_identical if change.is_none else result.is_success
    return SUCCESS if is_well and is_whole else MISSION_FAILED


def run_fork(
    options: argparse.Namespace,
    source: ForkSource,
    change: ForkChange,
    step_ns: int,
) -> tuple[ForkResult, Kept, bool]:
    """Run a recorded run again with a change, and keep it as the options ask for.

    Returns its result, what is to be said of its files, and whether they are complete.

    Args:
        options: Paths of its recording, page, video and trace.
        source: The recorded run.
        change: Takes effect at the fork.
        step_ns: The control step of the fork.

    Raises:
        BtMissionError: Where it is not the same up to the fork, or a file cannot be written.
    """
    from bt_mission.base.interrupts import TWO_WISHES
    from bt_mission.cli.run_shown import shown_on_page, with_end
    from bt_mission.commands.fork.stage import forked_stage
    from bt_mission.scenarios.fleets.run import fleet_report
    from bt_mission.sessions.drive import drive, driving

    with (
        forked_stage(source, change, step_ns, require=options.require) as (stage, finish),
        recording.recorder_for(options, stage) as keeping,
    ):
        ended: list[tuple[ForkResult, Kept, bool]] = []

        def end(reports: Reports) -> Report:
            result = finish(reports)
            summary: Summary = result.report
            if source.others:
                ends = {forked.source.name: forked.report for forked in (result, *result.others)}
                in_order = tuple(ends[name] for name in source.names)
                summary = fleet_report(source.fleet, stage, in_order)
            kept = keeping.finish(summary)
            ended.append((result, kept, not keeping.is_incomplete(kept)))
            return result.report

        if options.web:
            speed, interrupts = options.speed or 1.0, InterruptSignals(TWO_WISHES)
            with interrupts:
                steps = driving(stage, (), interrupts, speed=speed, paced_from_ns=step_ns)
                shown = with_end(steps, end)
                shown_on_page(options, stage, shown, interrupts, speed, until_ns=step_ns)
        else:
            end(drive(stage))
        return ended[0]


def fork_shown(
    path: Path, at_s: float, words: Sequence[str], free: Callable[[], AbstractContextManager[Any]]
) -> Path | None:
    """Fork a recording on a terminal that shows something else; give the fork's recording.

    A process of its own does it, since ROS may have to restart the interpreter.

    Args:
        path: Of the recording.
        at_s: Where to fork, s since the start.
        words: ``NAME=VALUE``, and options of the command with their values.
        free: Gives the terminal back for a while.
    """
    output = next(candidate for n in count_up(1) if not (candidate := beside(path, n)).exists())
    change: list[str] = []
    for number, word in enumerate(words):
        is_value = number > 0 and words[number - 1].startswith("--")
        change += [word] if is_value or word.startswith("--") else ["--set", word]
    options = ["fork", str(path), "--at", f"{at_s:.3f}", *change, "--record", str(output)]
    with free(), InterruptSignals():
        print(f"$ {shlex.join(['bt-mission', *options])}", flush=True)
        code = subprocess.run(  # noqa: S603 - ourselves
            python_command("-m", "bt_mission", *options), check=False, env=python_environment()
        ).returncode
        with suppress(EOFError):
            input("Press Enter to return to the replay")
    return output if code in (SUCCESS, MISSION_FAILED) and output.exists() else None


def beside(path: Path, number: int) -> Path:
    """Name the recording of a fork of a recording."""
    return path.with_name(f"{path.stem}_fork_{number}.mcap")


def offer(film: Timeline, robot: str) -> dict[str, str]:
    """Return what the page of a robot offers: the command, and why the run cannot be forked."""
    from bt_mission.commands.fork.source import refusal
    from bt_mission.recording.facts import RunFacts

    of_robot = ["--robot", robot] if len(film.robots) > 1 else []
    command = shlex.join(["bt-mission", "fork", str(film.path), *of_robot, "--at"])
    return {"command": command, "refusal": refusal(film.path, RunFacts(film.notes), film.why_cut)}


ADDITION = ReplayAddition("fork", fork_shown, offer)

COMMANDS = {
    "fork": Command(
        fork,
        "Repeats a recorded simulation from its start with the mission, world, robot, seed and "
        "inputs in the recording. Compares the trace with the recorded one, byte by byte, up to "
        "the control step at --at. Then the change takes effect, and the run continues. Files on "
        "the disk are not used.",
        (
            RECORDING,
            AT.but(help="fork at the first control step after this many seconds of the mission"),
            SET.but(
                help="set a variable of the mission at the fork; may be repeated",
                completes="",
            ),
            Option(
                "--mission FILE",
                "continue with this version of the mission file; it applies to nodes that start "
                "after the fork",
                input_file,
                completes="missions",
                takes=MISSIONS,
            ),
            REQUIRE,
            FAULT,
            Option(
                "--import-python",
                "import the mission's Python leaves and nodes from the working folder, which "
                "runs their code",
            ),
            recorded_robot("the first; a change needs the robot to which it applies"),
            JSON,
            *recording.RECORDING_OPTIONS,
            SPEED.but(
                help="simulated seconds per second from the fork on (default: 1)",
                needs=each("web", why="without a page a fork runs as fast as possible"),
            ),
            *web_options(),
        ),
        EPILOG,
        leaves_at_once=True,
    )
}
