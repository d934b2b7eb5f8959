"""``bt-mission replay``: show a recorded run."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from bt_mission.base.commands import added
from bt_mission.base.errors import BtMissionError
from bt_mission.base.file_kinds import RECORDINGS
from bt_mission.base.stamps import NS
from bt_mission.base.text import seconds
from bt_mission.cli.exits import INTERRUPTED, SUCCESS
from bt_mission.cli.options import AT, PLAIN, RECORDING, SPEED, recorded_robot
from bt_mission.cli.parser import Command, Option, each, refuse_for_kind
from bt_mission.cli.web import page_server, web_options

if TYPE_CHECKING:
    from bt_mission.executive.stored_trace import StoredTrace
    from bt_mission.recording.replay.timeline import Timeline

EPILOG = """\
examples:
  bt-mission run missions/explore.yaml --record explore.mcap
  bt-mission replay explore.mcap                    full screen, in real time
  bt-mission replay explore.mcap --speed 8 --at 60  8 times as fast, from 60 s
  bt-mission replay explore.mcap --web --open       in a browser
  bt-mission replay explore.mcap --once --at 12.5   the tree as it was then
  bt-mission replay trace.jsonl                     a line for each event

exit codes: 0 success, 2 no such file, or neither a recording nor a trace, 130 interrupted
"""


def replay(options: argparse.Namespace) -> int:
    """Play or print it, at its pace; gives the exit code."""
    from bt_mission.executive.stored_trace import read_trace
    from bt_mission.recording.reading import is_recording

    if is_recording(options.file):
        return _replay_recording(options)
    refuse_for_kind(options, "trace")
    return _tell_trace(options, read_trace(options.file))


def _replay_recording(options: argparse.Namespace) -> int:
    from bt_mission.cli.screen import is_drawable
    from bt_mission.recording.replay.timeline import read_timeline

    film = read_timeline(options.file, options.robot)
    if len(film.robots) > 1 and options.robot is None and not options.web:
        others = ", ".join(film.robots[1:])
        print(f"shown: {film.robots[0]}; with --robot NAME: {others}", file=sys.stderr)
    duration_s = (film.end_ns - film.start_ns) / NS
    if options.at > duration_s:
        raise BtMissionError(
            f"--at {options.at:g}: the recording ends at {seconds(duration_s)}", code="BT-1102"
        )
    if options.once:
        return _print_once(options, film)
    if options.web:
        return _serve_page(options, film)
    if options.plain or not is_drawable():
        return _tell_recording(options, film)
    return _draw(options, film)


def _draw(options: argparse.Namespace, film: Timeline) -> int:
    from bt_mission.base.memory import settle_memory
    from bt_mission.recording.replay.player import Player
    from bt_mission.views.terminal.marks import marks_for
    from bt_mission.views.tui.replay_app import ReplayApp

    player = Player(film, speed=options.speed or 1.0, at_s=options.at)
    player.play()
    settle_memory()
    starts = [addition.start for addition in added("replay")]
    ReplayApp(player, marks_for(sys.stdout.encoding), *starts[:1]).run()
    return SUCCESS


def _serve_page(options: argparse.Namespace, film: Timeline) -> int:
    import asyncio

    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.views.web.report.page import robot_runs, served_page_of

    begin = {"at": options.at, "speed": options.speed or 1.0}
    with InterruptSignals() as leaving:
        runs = [
            replace(run, data={**run.data, **begin, **_offers(options, film, run.robot)})
            for run in robot_runs(options.file, options.robot)
        ]
        with page_server(options, served_page_of(runs)) as server:
            asyncio.run(server.serve(lambda: leaving.count > 0))
    _say_cut(film)
    return INTERRUPTED


def _offers(options: argparse.Namespace, film: Timeline, robot: str) -> dict[str, Any]:
    """Return what the page of a robot offers to start."""
    if options.read_only:
        return {}
    return {addition.key: addition.offer(film, robot) for addition in added("replay")}


def _print_once(options: argparse.Namespace, film: Timeline) -> int:
    from bt_mission.cli.screen import print_tree
    from bt_mission.recording.replay.player import Player

    print_tree(Player(film, at_s=options.at).mission)
    _say_cut(film)
    return SUCCESS


def _tell_recording(options: argparse.Namespace, film: Timeline) -> int:
    from bt_mission.executive.stored_trace import trace_of

    if film.trace:
        _tell_trace(options, trace_of(str(film.path), film.trace))
    else:
        _tell_log(options, film)
    _say_cut(film)
    return SUCCESS


def _tell_log(options: argparse.Namespace, film: Timeline) -> None:
    """Print what a recording without a trace tells."""
    from bt_mission.base.wall_clock import Pacer
    from bt_mission.recording.replay.player import entries_of
    from bt_mission.views.terminal.lines import log_line
    from bt_mission.views.terminal.marks import marks_for

    marks = marks_for(sys.stdout.encoding)
    begin_ns = film.start_ns + round(options.at * NS)
    pacer = Pacer(options.speed, begin_ns)
    for entry in entries_of(film):
        if entry.time_ns >= begin_ns:
            pacer.hold(entry.time_ns, lambda: False)
            print(log_line(entry, film.start_ns, marks), flush=bool(options.speed))


def _tell_trace(options: argparse.Namespace, trace: StoredTrace) -> int:
    from bt_mission.base.wall_clock import Pacer
    from bt_mission.executive.events.log import glyphs_for, line_of

    glyphs = glyphs_for(sys.stdout.encoding)
    pacer = Pacer(options.speed, trace.start_ns + round(options.at * NS))
    for event in trace.events:
        if trace.seconds(event) < options.at or (event["event"] == "pose" and not options.poses):
            continue
        pacer.hold(int(event["t"]), lambda: False)
        print(
            f"{seconds(trace.seconds(event)):>10}  {line_of(event, glyphs)}",
            flush=bool(options.speed),
        )
    if trace.is_cut:
        print(f"{trace.file}: incomplete from here, in the middle of a line")
    return SUCCESS


def _say_cut(film: Timeline) -> None:
    if film.why_cut:
        print(f"{film.path}: ends here: {film.why_cut}")
    if film.missing:
        print(f"{film.path}: lacks {film.missing}")


_NO_TREE = each("trace", why="a trace has no tree; use a recording (bt-mission run --record)")

COMMANDS = {
    "replay": Command(
        replay,
        "Plays a recording (`bt-mission run --record FILE.mcap`) on a full screen, forwards and "
        "backwards, at any speed. In a pipe, with --plain, and for a trace (`run --trace FILE`), "
        "it prints one line per event with its virtual time. Failed tests save both files.",
        (
            RECORDING.but(
                help="a recording (MCAP), the folder of a bag, or a trace (JSON lines)",
                takes=(*RECORDINGS, "trace"),
            ),
            SPEED.but(
                help="virtual seconds per second (default: 1 on a full screen, else as fast as "
                "possible)"
            ),
            AT.but(
                form="--at --start S",
                help="start this many seconds after the start of the mission",
                default=0.0,
            ),
            Option(
                "--once",
                "print the tree at the time of --at, and exit",
                not_for=_NO_TREE,
            ),
            recorded_robot("the first; the map shows all"),
            PLAIN,
            Option("--poses", "also print the poses of the robot"),
            *(web_option.but(not_for=_NO_TREE) for web_option in web_options("once", "plain")),
        ),
        EPILOG,
    )
}
