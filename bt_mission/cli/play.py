"""``bt-mission play``: programs with the simulated robot, without a mission."""

from __future__ import annotations

import argparse
import json

from bt_mission.cli.argument_types import above_zero
from bt_mission.cli.exits import INTERRUPTED, SUCCESS
from bt_mission.cli.options import JSON, ROBOT, SEED, WORLD
from bt_mission.cli.parser import Command, Option
from bt_mission.core.dds.middleware import prepare_middleware
from bt_mission.core.text import escape_lines

TIMED_OUT = 124
"""As of `timeout`."""

WHY = {
    "ended": "all programs have ended",
    "idle": "the programs that remain only wait to be asked, and nobody will ask them",
    "limit": "the time is over",
    "interrupted": "interrupted",
}


def _say(time_s: float, name: str, line: str) -> None:
    print(f"{time_s:9.2f} s  {name}: {escape_lines(line)}", flush=True)


def play(options: argparse.Namespace) -> int:
    """Play the programs; gives the highest of their exit codes."""
    from bt_mission.sessions.playing import play as played_by

    prepare_middleware()
    played = played_by(
        options.programs,
        options.argument,
        world=options.world,
        robot=options.robot,
        seed=options.seed,
        limit_s=options.seconds,
        **({} if options.json else {"say": _say}),
    )
    if options.json:
        print(json.dumps(played.as_dict()))
    else:
        for name, code in played.exit_codes.items():
            print(f"{name}: {'runs' if code is None else f'exit code {code}'}")
        print(f"{played.time_s:g} s: {WHY[played.why]}")
    if played.why in ("limit", "interrupted"):
        return TIMED_OUT if played.why == "limit" else INTERRUPTED
    return max((code for code in played.exit_codes.values() if code is not None), default=SUCCESS)


COMMANDS = {
    "play": Command(
        play,
        "Runs programs that use rclpy, unchanged, with a simulated robot and the action servers of "
        "bt-mission, on the virtual clock: your server and your client, or a client alone. It "
        "ends with the last program, or when those that remain only wait to be asked. Ctrl-C is "
        "sent to all programs; a second one ends the run.",
        (
            Option(
                "programs", "Python files, each alone or in quotes with its arguments", nargs="+"
            ),
            Option(
                "--argument WORD", "an argument for all programs; may be repeated", repeats=True
            ),
            WORLD.but(help="name or file of a world (default: empty_arena)"),
            ROBOT.but(help="name or file of a robot"),
            SEED,
            Option("--for SECONDS", "end after this virtual time", above_zero, dest="seconds"),
            JSON,
        ),
        "exit codes: the highest of the programs; 2 bad input, 124 after --for, 130 interrupted",
    )
}
