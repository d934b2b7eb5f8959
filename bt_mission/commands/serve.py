"""``bt-mission serve``: the executive as an action server."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from bt_mission.base.commands import added, hints
from bt_mission.cli.exits import INTERRUPTED, MISSION_FAILED, SUCCESS
from bt_mission.cli.extensions import show_options, shown_beside
from bt_mission.cli.options import (
    ALLOW_DUPLICATES,
    EDITABLE,
    NAMESPACE,
    NETWORK,
    WALL_CLOCK,
    announce,
    prepare_graph,
)
from bt_mission.cli.parser import Command, Option, each
from bt_mission.cli.ros_arguments import checked, of_node
from bt_mission.cli.web import watching_process, web_options

if TYPE_CHECKING:
    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.ros.graph import GraphConnection
    from bt_mission.sessions.mission_server import MissionServer
    from bt_mission.sessions.served_missions import ServedMissions
    from bt_mission.sessions.session import Onlooker, Session

_MORE = "".join(f"{line}\n" for line in hints("serve"))
EPILOG = f"""\
examples:
  bt-mission serve
  bt-mission serve --missions ~/patrols --missions ~/tests --allow-python
  bt-mission serve --record runs
{_MORE}
in a mission:
  - execute_mission: {{path: missions/patrol.yaml}}
    timeout: 300

ROS arguments can follow: --ros-args -r __ns:=/robot1 -r __node:=executive -p use_sim_time:=true

exit codes: 0 ended by Ctrl-C with every goal ended, 1 with an incomplete recording, 2 bad input,
130 ended by a second Ctrl-C
"""


def _offered(missions: ServedMissions) -> str:
    folders = ", ".join(str(folder.resolve()) for folder in missions.folders) or "no folder"
    python = "imported" if missions.allow_python else "refused (--allow-python)"
    texts = "accepted" if missions.allow_text else "refused (--allow-text)"
    return f"missions of {folders}; Python leaves {python}, missions sent as text {texts}"


def _missions(options: argparse.Namespace) -> ServedMissions:
    """Return the missions to serve: those that a command adds, or those of folders."""
    from bt_mission.sessions.served_missions import ServedMissions, folders_to_serve

    for addition in added("serve"):
        missions: ServedMissions | None = addition.missions(options)
        if missions is not None:
            return missions
    return ServedMissions(
        folders_to_serve(options.missions),
        allow_python=options.allow_python,
        allow_text=options.allow_text,
    )


def serve(options: argparse.Namespace) -> int:
    """Serve until interrupted; gives the exit code."""
    announce("joining the ROS graph")
    prepare_graph(options)
    from bt_mission.base.interrupts import TWO_WISHES, InterruptSignals
    from bt_mission.recording.served import ServedRecordings
    from bt_mission.ros.graph import GraphConnection, NodeOptions
    from bt_mission.sessions.mission_server import MissionServer, MissionServerOptions
    from bt_mission.views.terminal.live_view import ServedLines

    def say(text: str) -> None:
        with suppress(OSError):  # a closed output: missions are carried out for their clients
            print(text, flush=True)

    recordings = ServedRecordings(options.record, say) if options.record else None

    def onlookers(_session: Session) -> Iterator[Onlooker]:
        yield ServedLines(sys.stdout)
        if recordings is not None:
            yield recordings.onlooker()

    missions = _missions(options)
    ros_args = of_node(checked(options.ros_args), NodeOptions().name)
    graph = GraphConnection(wall_clock=options.wall_clock, ros_args=ros_args)
    try:
        node = MissionServer(
            graph.host,
            graph.drop,
            node=NodeOptions(
                namespace=options.namespace,
                context=graph.context,
                use_sim_time=graph.has_clock,
            ),
            options=MissionServerOptions(
                missions=missions,
                on_new_goal=options.on_new_goal,
                allow_duplicates=options.allow_duplicates,
                say=say,
                onlookers=onlookers,
                editable=options.editable,
            ),
        )
        graph.host(node)
        name = node.resolve_topic_name("execute_mission")
        say(f"{name} waits for missions ({'/clock' if graph.has_clock else 'wall clock'})")
        say(_offered(missions))
        page = watching_process(options, node.get_fully_qualified_name())
        if options.allow_python or options.editable:
            watch = graph.watch_users()
            watch.last_words.append(lambda: node.abandon("left while a callback did not return"))
        with InterruptSignals(TWO_WISHES) as interrupts, page, shown_beside(options):
            if not _serve_missions(graph, node, interrupts):
                return INTERRUPTED
        graph.drain()
        graph.drop(node)
    finally:
        graph.close()
    if recordings is not None and not recordings.are_whole:
        return MISSION_FAILED
    return SUCCESS


def _serve_missions(
    graph: GraphConnection, node: MissionServer, interrupts: InterruptSignals
) -> bool:
    """Serve until a signal; return whether every goal has ended.

    An exception ends the mission that runs, with its goals, before it is raised.
    """
    from bt_mission.base.errors import callback_failure

    failure: Exception | None = None
    while node.is_busy or not (interrupts.count or failure):
        if interrupts.count == 1:
            node.close(f"interrupted by {interrupts.name}")
        elif interrupts.count > 1:
            node.abandon(f"ended at once by a second {interrupts.name}")
            return False
        try:
            graph.step(node.executive, node.mission_node)
            node.look()
        except Exception as error:
            reason = callback_failure(error)
            if failure is not None:
                node.abandon(reason)
                raise
            failure = error
            node.close(reason)
    if failure is not None:
        raise failure
    return True


COMMANDS = {
    "serve": Command(
        serve,
        "Serves the action /execute_mission, which runs one mission at a time against the action "
        "servers of a running ROS graph. The services /bt_mission/pause, resume, step, stop and "
        "breakpoint control the mission; the topics /bt_mission/tree, changes and state report "
        "its progress. Only missions in the folders of --missions are accepted. Ctrl-C halts the "
        "mission and waits until every goal has ended and the robot has stopped; a second Ctrl-C "
        "exits at once.",
        (
            NAMESPACE.but(help="namespace of the robot whose servers run missions"),
            Option(
                "--missions DIR",
                "serve only the missions in this folder and its subfolders; may be repeated "
                "(default: ./missions if it exists, else the shipped missions)",
                Path,
                repeats=True,
            ),
            Option(
                "--allow-python",
                "accept missions with Python leaves from these folders or plug-ins, and with "
                "nodes; leaves are imported, nodes are not started",
            ),
            Option(
                "--allow-text",
                "accept missions sent as text in a goal, which cannot use other files or Python",
            ),
            Option(
                "--on-new-goal",
                "how to handle a goal while a mission runs (default: replace the mission)",
                choices=("replace", "refuse"),
                default="replace",
            ),
            *(option for addition in added("serve") for option in addition.options),
            EDITABLE.but(
                help="take new versions of the running mission from `bt-mission revise`",
                needs=each("allow_text", why="a new version comes as text"),
            ),
            WALL_CLOCK,
            Option(
                "--record DIR",
                "record each mission to a new file in this folder: MISSION_001.mcap, ...",
                Path,
                page="recording",
            ),
            NETWORK,
            ALLOW_DUPLICATES,
            *web_options(),
            *show_options(),
        ),
        EPILOG,
        takes_ros_args=True,
        leaves_at_once=True,
    )
}
