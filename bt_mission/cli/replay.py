"""``bt-mission replay``: tell a run that is over again."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.options import speed


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "replay",
        help="tell again what happened in a run, from its trace",
        description="Tells what a trace holds, as 'bt-mission run --trace FILE' writes it and "
        "failed tests leave it: a line for each event, with its virtual time.",
    )
    parser.add_argument("file", type=Path, help="a trace")
    parser.add_argument(
        "--speed",
        type=speed,
        help="virtual seconds per second, 1 for real time (default: all at once)",
    )
    parser.add_argument("--poses", action="store_true", help="where the robot was, too")
    parser.add_argument(
        "--start", type=float, default=0.0, metavar="S", help="begin so many seconds in"
    )
    parser.set_defaults(command=replay)


def replay(options: argparse.Namespace) -> int:
    """Print it, at its pace."""
    from bt_mission.pacing import Pacer
    from bt_mission.terminal.glyphs import glyphs_for
    from bt_mission.traces.stored import read_trace
    from bt_mission.traces.words import told

    trace = read_trace(options.file)
    glyphs = glyphs_for(sys.stdout.encoding)
    pacer = Pacer(options.speed, trace.start_ns + round(options.start * 1e9))
    for event in trace.events:
        if trace.seconds(event) < options.start or (event["event"] == "pose" and not options.poses):
            continue
        pacer.hold(int(event["t"]), lambda: False)
        print(f"{trace.seconds(event):8.2f} s  {told(event, glyphs)}", flush=bool(options.speed))
    if trace.is_cut:
        print(f"{trace.file}: cut here, in the middle of a line")
    return SUCCESS
