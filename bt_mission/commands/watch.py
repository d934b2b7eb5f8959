"""``bt-mission watch``: monitor a mission that runs elsewhere."""

from __future__ import annotations

import argparse
import os
import select
import sys
from typing import TYPE_CHECKING

from bt_mission.cli.argument_types import seconds
from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS
from bt_mission.cli.options import JSON, NETWORK, PLAIN, prepare_graph
from bt_mission.cli.parser import Command, Option, each
from bt_mission.cli.web import has_input_ended, web_options, web_server
from bt_mission.commands.foxglove.command import foxglove_options, serve_graph

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bt_mission.executive.events.feed import MissionFeed
    from bt_mission.executive.events.mission_state import MissionState
    from bt_mission.executive.events.source import ExecutiveSource, ListedExecutive
    from bt_mission.ros.discovery import ExecutiveDirectory

WAIT_S = 0.1
LEARN_S = 0.6
"""Wall time to wait for the names of missions."""

SAY_S = 1.8
"""Wall time after which a line reports that no executive is there."""

STATUSES_S = 2.0
"""Wall time to wait for statuses; without them the tree is shown as it is known."""

REQUIREMENTS_S = 0.3
"""Wall time to wait for requirements once all else is known: a mission may have none."""

EPILOG = """\
examples:
  bt-mission run explore --visible --speed 1  in one terminal
  bt-mission watch                            in another terminal
  bt-mission watch robot1                     one of several executives, by its namespace
  bt-mission watch --web --open               in a browser
  bt-mission watch --foxglove                 all topics, for Foxglove and Lichtblick
  bt-mission watch --once                     the tree as it is now
  bt-mission watch --json | jq -c 'select(.event == "status")'

exit codes: 0 closed, 1 no executive within --wait, 2 bad input, 130 interrupted
"""


def watch(options: argparse.Namespace) -> int:
    """Show the mission until interrupted; return the exit code."""
    prepare_graph(options)
    if options.foxglove:
        return serve_graph(options)
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


def is_drawable() -> bool:
    """Can a picture stand on the terminal? Says so where it cannot."""
    if not (sys.stdout.isatty() and sys.stdin.isatty()):
        return False
    if os.environ.get("TERM", "dumb") in ("dumb", "unknown"):
        term = os.environ.get("TERM", "")
        print(
            f"TERM={term}: this terminal cannot show the full-screen view; printing plain lines",
            file=sys.stderr,
        )
        return False
    return True


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


def look_for(observer: ExecutiveDirectory, options: argparse.Namespace) -> ExecutiveSource | None:
    """Return the executive that the options name, once it is there; None if it is late."""
    from bt_mission.base.wall_clock import Stopwatch
    from bt_mission.executive.events.source import choose, nobody, wanted_name

    wanted = wanted_name(options.executive)
    since = Stopwatch()
    missions: dict[str, str] = {}
    has_said = False
    while True:
        observer.serve(WAIT_S)
        is_over = observer.is_over()
        executives = observer.find()
        is_late = options.wait is not None and since.elapsed_s > options.wait
        is_named = any(executive.name == wanted for executive in executives)
        if is_named or (executives and (is_over or is_late)):
            if wanted is not None and not is_named:
                _learn_missions(observer, executives, missions)
                named = [name for name, mission in missions.items() if mission == options.executive]
                wanted = named[0] if len(named) == 1 else wanted
            chosen = choose(executives, wanted)
            if chosen is not None:
                if chosen.fault:
                    print(f"{chosen.name}: {chosen.fault}", file=sys.stderr)
                return observer.attach(chosen.name, with_robot=False)
        if is_late:
            print(nobody(wanted, executives, observer.where), file=sys.stderr)
            return None
        if not has_said and since.elapsed_s > SAY_S and (is_over or not executives):
            print(f"{nobody(wanted, executives, observer.where)}\nlooking ...", file=sys.stderr)
            has_said = True


def _learn_missions(
    observer: ExecutiveDirectory, executives: Sequence[ListedExecutive], missions: dict[str, str]
) -> None:
    """Note the name of the mission that each executive runs, as far as they say it in time."""
    from bt_mission.base.wall_clock import Stopwatch
    from bt_mission.executive.events.feed import MissionFeed
    from bt_mission.executive.events.mission_state import MissionState

    new = [each.name for each in executives if each.name not in missions and not each.is_foreign]
    links = {name: observer.attach(name, with_robot=False) for name in new}
    feeds = {name: MissionFeed(MissionState()) for name in new}
    since = Stopwatch()
    while links.keys() - missions.keys() and since.elapsed_s < LEARN_S:
        observer.serve(WAIT_S)
        for name, link in links.items():
            for batch in link.take(needs_statuses=False).messages:
                feeds[name].take(batch)
            if tree := feeds[name].mission.tree:
                missions[name] = tree.mission
    for link in links.values():
        link.close()


def _print_once(observer: ExecutiveDirectory, link: ExecutiveSource) -> int:
    from bt_mission.base.wall_clock import Stopwatch
    from bt_mission.executive.events.feed import MissionFeed
    from bt_mission.executive.events.mission_file import FileCheck, MissionFile
    from bt_mission.executive.events.mission_state import MissionState

    mission = MissionState()
    feed = MissionFeed(mission)
    since = Stopwatch()
    since_complete: Stopwatch | None = None
    file: MissionFile | None = None
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


def print_tree(mission: MissionState) -> None:
    """Print the tree of a mission as it is, no wider than the terminal."""
    from bt_mission.views.terminal.lines import whole_tree
    from bt_mission.views.terminal.marks import marks_for

    width = os.get_terminal_size().columns if sys.stdout.isatty() else None
    for line in whole_tree(mission, marks_for(sys.stdout.encoding), width):
        print(line)


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
            *foxglove_options("once", "json", "plain", "web", "executive", "wait"),
            Option("--until-input-ends", argparse.SUPPRESS),
        ),
        EPILOG,
    )
}
