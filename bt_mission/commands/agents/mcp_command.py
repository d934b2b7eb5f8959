"""``bt-mission mcp``: a gateway for agents, which propose missions and ask to drive."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Coroutine
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.base.errors import BtMissionError
from bt_mission.cli.argument_types import input_file, port
from bt_mission.cli.exits import INTERRUPTED, SUCCESS
from bt_mission.cli.extensions import ServeAddition
from bt_mission.cli.options import NETWORK, prepare_graph
from bt_mission.cli.parser import Command, Option, each

if TYPE_CHECKING:
    from bt_mission.commands.agents.folder import AgentFolder
    from bt_mission.commands.agents.site import Site
    from bt_mission.ros.graph import GraphConnection
    from bt_mission.sessions.served_missions import ServedMissions

PORT = 8770
BATCH_S = 0.01
"""Wall time for which messages are received at a stretch: `stop` waits for it."""

EPILOG = """\
examples:
  bt-mission mcp --site site.yaml              for a client that starts this command
  bt-mission mcp --site site.yaml --http       for clients of this machine; prints the link

exit codes: 0 the client has left, 2 bad input, 130 interrupted
"""


def require_agents(what: str) -> None:
    """Refuse a command or an option without the packages of the extra.

    Raises:
        BtMissionError: With what to install.
    """
    names = ("mcp", "cryptography", "starlette", "uvicorn")
    missing = [name for name in names if find_spec(name) is None]
    if missing:
        needed = " and ".join(missing)
        raise BtMissionError(f"{what} needs {needed}: pip install 'bt-mission[mcp]'", code="BT-905")


def site_option(what: str) -> Option:
    """Return the option that names the file of the site."""
    return Option(
        "--site SITE.yaml",
        "the file of the site: robot, world, requirements, approvers",
        input_file,
        takes=("site",),
        page="agents",
        check=partial(require_agents, what),
    )


AGENTS = Option(
    "--agents DIR",
    "the folder of proposals and permits (default: agents, beside the site's file)",
    Path,
    needs=each("site"),
)


def site_of(options: argparse.Namespace) -> tuple[Site, AgentFolder]:
    """Return the site of the options, and its folder.

    Raises:
        InputError: With every error of the file.
        BtMissionError: No file is given, or the folder cannot be made.
    """
    from bt_mission.commands.agents.folder import AgentFolder
    from bt_mission.commands.agents.site import load_site

    if options.site is None:
        raise BtMissionError("--site is missing: the file of the site", code="BT-1102")
    site = load_site(options.site)
    return site, AgentFolder(options.agents or options.site.parent / "agents")


def mcp(options: argparse.Namespace) -> int:
    """Serve until the client leaves."""
    site, folder = site_of(options)
    prepare_graph(options)
    import asyncio

    from bt_mission.commands.agents.examiner import Examiner
    from bt_mission.commands.agents.gateway import AgentGateway
    from bt_mission.commands.agents.jobs import run_in_child
    from bt_mission.commands.agents.robot import RosRobot
    from bt_mission.commands.agents.server import agent_server
    from bt_mission.commands.agents.transports import serve_http, serve_stdio
    from bt_mission.ros.graph import GraphConnection

    print("reading the types of all actions ...", file=sys.stderr)
    with GraphConnection(wall_clock=True) as graph:
        node = graph.host_quiet("bt_mission_mcp")
        robot = RosRobot(node, partial(_serve, graph), site.written.namespace)
        examiner = Examiner(site)
        gateway = AgentGateway(site, folder, robot, run_in_child, examiner)
        print(
            f"site '{site.name}' offers {len(gateway.capabilities['actions'])} actions",
            file=sys.stderr,
        )

        async def close() -> None:
            await gateway.close()
            await examiner.close()

        async def serve() -> None:
            _close_on_signal(close)
            server, beside = agent_server(gateway), robot.serve_forever()
            try:
                if options.http:
                    number = PORT if options.port is None else options.port
                    say = partial(print, file=sys.stderr, flush=True)
                    await serve_http(server, number, say, beside)
                else:
                    await serve_stdio(server, beside)
            finally:
                await close()

        asyncio.run(serve())
    return SUCCESS


def _close_on_signal(close: Callable[[], Coroutine[Any, Any, None]]) -> None:
    """Have the first signal end a running job before the process, and the second one end both.

    The thread that reads standard input cannot be ended: the process does not wait for it.
    """
    import asyncio
    import signal

    from bt_mission.base.interrupts import SIGNALS

    loop = asyncio.get_running_loop()
    leaving: list[asyncio.Task[None]] = []

    async def leave() -> None:
        try:
            await close()
        finally:
            os._exit(INTERRUPTED)

    def note() -> None:
        if leaving:
            os._exit(INTERRUPTED)
        leaving.append(loop.create_task(leave()))

    for number in SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            loop.add_signal_handler(number, note)


def _serve(graph: GraphConnection) -> None:
    from bt_mission.base.wall_clock import Stopwatch

    since = Stopwatch()
    while since.elapsed_s < BATCH_S and graph.executor.serve(0.0):
        pass


COMMANDS = {
    "mcp": Command(
        mcp,
        "Serves agents by the Model Context Protocol. An agent can read what the robot offers, "
        "check missions, propose them, prove and simulate them, read the results, and stop the "
        "robot. It can drive only with a permit that a person gives with `bt-mission approve`, "
        "and only through `bt-mission serve --site`. Each call is written to calls.jsonl.",
        (
            site_option("bt-mission mcp"),
            AGENTS,
            Option("--http", "serve Streamable HTTP on 127.0.0.1 instead of standard input"),
            Option(
                "--port N",
                f"listen on this port (default: {PORT}; 0: any free port)",
                port,
                needs=each("http"),
            ),
            NETWORK,
        ),
        EPILOG,
        leaves_at_once=True,
    )
}


def permitted_missions(options: argparse.Namespace) -> ServedMissions | None:
    """Return the missions of a site, those with a permit, and of named folders; None without.

    Raises:
        InputError: With every error of the site's file.
        BtMissionError: The namespace is not the site's.
    """
    if options.site is None:
        return None
    from bt_mission.commands.agents.permitted import PermittedMissions
    from bt_mission.sessions.served_missions import folders_to_serve

    site, folder = site_of(options)
    if options.namespace.strip("/") != site.written.namespace.strip("/"):
        raise BtMissionError(
            f"--namespace: the namespace of the site is '{site.written.namespace}'", code="BT-1102"
        )
    for name in sorted(site.only_simulated):
        message = "only simulations have its signals: it halts nothing on this robot"
        print(f"warning: requirement '{name}': {message}", file=sys.stderr)
    folders = folders_to_serve(options.missions) if options.missions else ()
    return PermittedMissions(folders, options.allow_python, site=site, folder=folder)


ADDITION = ServeAddition(
    (
        site_option("--site").but(
            help="run proposals of agents that have a permit; a violated requirement of this "
            "site halts them",
            excludes=each("allow_text", "editable", why="a permit decides on the mission"),
        ),
        AGENTS,
    ),
    permitted_missions,
)
