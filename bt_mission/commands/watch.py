"""``bt-mission watch``: monitor a mission that runs elsewhere."""

from __future__ import annotations

import argparse
import select
import sys
from typing import TYPE_CHECKING

from bt_mission.base.commands import hints
from bt_mission.cli.argument_types import seconds
from bt_mission.cli.executives import WAIT_S, look_for
from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS
from bt_mission.cli.extensions import show_options, shown_by
from bt_mission.cli.options import JSON, NETWORK, PLAIN, prepare_graph
from bt_mission.cli.parser import Command, Option, each
from bt_mission.cli.screen import is_drawable, print_tree
from bt_mission.cli.web import has_input_ended, web_options, web_server

if TYPE_CHECKING:
    from bt_mission.executive.events.feed import MissionFeed
    from bt_mission.executive.events.source import ExecutiveSource
    from bt_mission.ros.discovery import ExecutiveDirectory

STATUSES_S = 2.0
"""Wall time to wait for statuses; without them the tree is shown as it is known."""

REQUIREMENTS_S = 0.3
"""Wall time to wait for requirements once all else is known: a mission may have none."""

_MORE = "".join(f"{line}\n" for line in hints("watch"))
EPILOG = f"""\
examples:
  bt-mission run explore --visible --speed 1  in one terminal
  bt-mission watch                            in another terminal
  bt-mission watch robot1                     one of several executives, by its namespace
  bt-mission watch --web --open               in a browser
{_MORE}\
  bt-mission watch --once                     the tree as it is now
  bt-mission watch --json | jq -c 'select(.event == "status")'

exit codes: 0 closed, 1 no executive within --wait, 2 bad input, 130 interrupted
"""


def watch(options: argparse.Namespace) -> int:
    """Show the mission until interrupted; return the exit code."""
    prepare_graph(options)
    for shows in shown_by(options):
        return shows.instead(options)
    from bt_mission.ros.discovery import ExecutiveDirectory

    with ExecutiveDirectory() as observer:
        try:
            if options.web:
                return _serve_page(observer, options)
            if not (options.once or options.json or options.plain) and is_drawable():
                return _draw(observer, options)
            link = look_for(observer, options)
            if link is None:
                return MISSION_FAILED
            if options.once:
                return _print_once(observer, link)
            return _follow(observer, link, as_json=options.json)
        except KeyboardInterrupt:
            return INTERRUPTED


def _draw(observer: ExecutiveDirectory, options: argparse.Namespace) -> int:
    from bt_mission.base.memory import settle_memory
    from bt_mission.executive.events.source import nobody, wanted_name
    from bt_mission.views.terminal.marks import marks_for
    from bt_mission.views.tui.app import WatchApp

    name = wanted_name(options.executive)
    settle_memory()
    app = WatchApp(observer, marks_for(sys.stdout.encoding), name, wait_s=options.wait)
    app.run()
    if app.return_code:
        print(nobody(name, (), observer.where), file=sys.stderr)
        return MISSION_FAILED
    return SUCCESS


def _serve_page(observer: ExecutiveDirectory, options: argparse.Namespace) -> int:
    import asyncio

    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.executive.events.source import nobody, wanted_name
    from bt_mission.views.web.live import LiveMission

    name = wanted_name(options.executive)
    shown = LiveMission(observer, name)

    def is_nobody_there() -> bool:
        return options.wait is not None and shown.nobody_s > options.wait

    with InterruptSignals() as leaving, web_server(options, shown) as server:

        def is_over() -> bool:
            is_left = options.until_input_ends and has_input_ended()
            return leaving.count > 0 or is_left or is_nobody_there()

        asyncio.run(server.serve(is_over))
    if is_nobody_there():
        print(nobody(name, (), observer.where), file=sys.stderr)
        return MISSION_FAILED
    return INTERRUPTED if leaving.count else SUCCESS


def _print_once(observer: ExecutiveDirectory, link: ExecutiveSource) -> int:
    from bt_mission.base.wall_clock import Stopwatch
    from bt_mission.executive.events.feed import MissionFeed
    from bt_mission.executive.events.mission_file import FileCheck, MissionOrigin
    from bt_mission.executive.events.mission_state import MissionState

    mission = MissionState()
    feed = MissionFeed(mission)
    since = Stopwatch()
    since_complete: Stopwatch | None = None
    file: MissionOrigin | None = None
    while since.elapsed_s < STATUSES_S:
        observer.serve(WAIT_S)
        for batch in link.take(needs_statuses=feed.needs_statuses).messages:
            feed.take(batch)
            file = batch.file or file
        if _is_complete(feed):
            since_complete = since_complete or Stopwatch()
            if mission.requirements or since_complete.elapsed_s > REQUIREMENTS_S:
                break
    print_tree(mission)
    check = FileCheck()
    check.look(file)
    if check.note and file is not None:
        print(f"{file.path}: {check.note}; `bt-mission revise` applies it", file=sys.stderr)
    return SUCCESS


def _is_complete(feed: MissionFeed) -> bool:
    mission = feed.mission
    if mission.state is None or (mission.state.run and mission.tree is None):
        return False
    if not mission.state.run:
        return True  # idle: there is no tree
    is_known = feed.sequence is not None
    return is_known and (mission.ticks is not None or mission.status != "running")


def _follow(observer: ExecutiveDirectory, link: ExecutiveSource, *, as_json: bool) -> int:
    """Print what happens, until whoever reads has left."""
    from bt_mission.executive.events.codec import json_line
    from bt_mission.executive.events.feed import MissionFeed
    from bt_mission.executive.events.mission_state import MissionState
    from bt_mission.views.terminal.followed import FollowedLines
    from bt_mission.views.terminal.marks import marks_for

    mission = MissionState()
    feed = MissionFeed(mission)
    followed = FollowedLines(feed, marks_for(sys.stdout.encoding))
    was_there = True
    while not _reader_has_left():
        observer.serve(WAIT_S)
        for batch in link.take(needs_statuses=feed.needs_statuses).messages:
            if not as_json:
                for line in followed.take(batch):
                    print(line, flush=True)
                continue
            for event in feed.take(batch):
                print(json_line(event, mission.tree.nodes if mission.tree else ()), flush=True)
        if link.is_there != was_there:
            was_there = link.is_there
            print(f"{link.name} {'returned' if was_there else 'disappeared'}", file=sys.stderr)
    return INTERRUPTED


def _reader_has_left() -> bool:
    """Has the other end of a pipe been closed? Without looking, only the next line would tell."""
    poll = select.poll()
    poll.register(sys.stdout.fileno(), 0)
    return any(event & (select.POLLERR | select.POLLHUP) for _, event in poll.poll(0))


COMMANDS = {
    "watch": Command(
        watch,
        "Attaches to an executive of the ROS graph (`run --attach`, `run --visible`, `serve`). "
        "Shows its tree, the status of each node with its reason, goals, variables and the "
        "robot's pose. Waits until an executive appears, and until it returns if it disappears. "
        "Does not affect the mission.",
        (
            Option(
                "executive",
                "name or namespace of the executive, such as /robot1/bt_mission or robot1 "
                "(default: the only one, or one chosen from a list)",
                nargs="?",
                completes="executives",
            ),
            Option("--once", "print the current tree and exit"),
            JSON.but(
                help="print events, one JSON object per line",
                excludes=each("once"),
            ),
            PLAIN.but(excludes=each("once", "json")),
            Option(
                "--wait SECONDS",
                "exit with code 1 if no executive appears within this time (default: keep looking)",
                seconds,
            ),
            NETWORK,
            *web_options("once", "json", "plain"),
            *show_options("once", "json", "plain", "web", "executive", "wait"),
            Option("--until-input-ends", argparse.SUPPRESS),
        ),
        EPILOG,
    )
}
