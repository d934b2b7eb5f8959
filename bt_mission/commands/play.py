"""``bt-mission play``: programs with the simulated robot, without a mission."""

from __future__ import annotations

import argparse
import json
from contextlib import ExitStack

from bt_mission.base.dds.middleware import prepare_middleware
from bt_mission.base.text import escape_lines
from bt_mission.cli import recording
from bt_mission.cli.argument_types import above_zero
from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS
from bt_mission.cli.options import CMD_VEL_TYPE, FAULT, JSON, ROBOT, SEED, SPEED, WORLD
from bt_mission.cli.parser import Command, Option
from bt_mission.cli.run_plan import most_obstacles, takes_faults, with_faults, written_faults
from bt_mission.cli.run_shown import shown_on_page, shown_on_screen
from bt_mission.cli.web import web_options

TIMED_OUT = 124
"""As of `timeout`."""


def _say(time_s: float, name: str, line: str) -> None:
    print(f"{time_s:9.2f} s  {name}: {escape_lines(line)}", flush=True)


def play(options: argparse.Namespace) -> int:
    """Play the programs; gives the highest of their exit codes."""
    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.cli.screen import is_drawable
    from bt_mission.scenarios.faults.live import LiveFaults
    from bt_mission.sessions.drive import finish
    from bt_mission.sessions.playing import Playing
    from bt_mission.sessions.stage_robot import StageOptions

    prepare_middleware()
    options.attach = False  # of `run`, with which the views are shared
    faults = written_faults(options)
    on_screen = options.tui and is_drawable()
    speed = options.speed or (1.0 if options.web or on_screen else None)
    interrupts = InterruptSignals(2)
    with ExitStack() as stack:
        stack.enter_context(interrupts)
        playing = Playing(
            options.programs,
            options.passed_on,
            world=options.world,
            robot=options.robot,
            seed=options.seed,
            limit_s=options.seconds,
            options=StageOptions(
                props=most_obstacles() if faults or options.web else 0,
                command_type=options.cmd_vel_type,
            ),
            **({} if options.json or on_screen else {"say": _say}),
        )
        stage = stack.enter_context(playing).stage
        live = LiveFaults(stage) if takes_faults(options) else None
        stack.enter_context(with_faults(stage, faults, lambda reports: reports[0], live))
        files = stack.enter_context(recording.recorder_for(options, stage))
        steps = playing.steps(interrupts, speed=speed)
        if options.web:
            played = shown_on_page(options, stage, steps, interrupts, speed, live=live)
        else:
            played = shown_on_screen(stage, steps, interrupts) if on_screen else finish(steps)
        kept = files.finish(stage.report())
        is_wrong = files.is_incomplete(kept)
        if stage.watch is not None:
            played.flaws += stage.watch.flaws
            is_wrong = is_wrong or (options.strict and bool(played.flaws))
    if options.json:
        played.warnings = stage.program_warnings
        print(json.dumps(played.as_dict() | kept))
    else:
        for line in played.lines if on_screen else ():
            _say(*line)
        for name, code in played.exit_codes.items():
            print(f"{name}: {'runs' if code is None else f'exit code {code}'}")
        print("\n".join([played.verdict, *played.flaws, *recording.file_lines(kept)]))
    if played.why in ("limit", "interrupted"):
        return TIMED_OUT if played.why == "limit" else INTERRUPTED
    is_wrong = is_wrong or played.why == "failed"
    codes = [code for code in played.exit_codes.values() if code is not None]
    return max(codes, default=SUCCESS) or (MISSION_FAILED if is_wrong else SUCCESS)


COMMANDS = {
    "play": Command(
        play,
        "Runs programs that use rclpy, unchanged, with a simulated robot and the action servers of "
        "bt-mission, on the virtual clock: your server and your client, or a client alone. It "
        "ends with the last program, or when those that remain only wait to be asked: a server "
        "whose client has ended, unless --for is given. Ctrl-C is "
        "sent to all programs; a second one ends the run.",
        (
            Option(
                "programs",
                "Python files, modules, or console scripts of installed packages, each alone or "
                "in quotes with its arguments; what follows -- are arguments for all of them",
                nargs="+",
            ),
            WORLD.but(help="name or file of a world (default: empty_arena)"),
            ROBOT.but(help="name or file of a robot"),
            CMD_VEL_TYPE,
            SEED,
            Option("--for SECONDS", "end after this virtual time", above_zero, dest="seconds"),
            FAULT,
            SPEED.but(
                help="simulated seconds per second; 1 is real time (default: as fast as possible)"
            ),
            Option("--strict", "fail if code of a program holds the clock, as the times are wrong"),
            JSON,
            Option(
                "--tui",
                "show the full-screen view of `bt-mission watch`, in real time unless --speed is "
                "given",
                excludes={"json": ""},
            ),
            *web_options("tui"),
            *recording.RECORDING_OPTIONS,
        ),
        "exit codes: the highest of the programs; 1 in a deadlock, with --strict, or if a file is "
        "incomplete, 2 bad input, 124 after --for, 130 interrupted",
        passes_on=True,
        leaves_at_once=True,
    )
}
