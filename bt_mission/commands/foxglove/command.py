"""The options of commands that show a mission in Foxglove or Lichtblick, and what they do."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from typing import TYPE_CHECKING

from bt_mission.cli.argument_types import port
from bt_mission.cli.exits import INTERRUPTED, SUCCESS
from bt_mission.cli.extensions import ShowAddition
from bt_mission.cli.parser import Option, each
from bt_mission.cli.web import has_input_ended, require_server, to_stderr, watch_beside

if TYPE_CHECKING:
    from bt_mission.commands.foxglove.server import FoxgloveServer
    from bt_mission.sessions.session import Session


def foxglove_options(*instead: str) -> tuple[Option, ...]:
    """Return whether topics are served to Foxglove, and where.

    Args:
        instead: Options of the command that show something else.
    """
    group = "in Foxglove or Lichtblick"
    return (
        Option(
            "--foxglove",
            "serve all topics to Foxglove and Lichtblick on this machine, and print the address",
            group=group,
            excludes=each(*instead),
            check=partial(require_server, "--foxglove"),
        ),
        Option(
            "--foxglove-port N",
            "listen on this port (default: 8765; 0: any free port)",
            port,
            group=group,
            needs=each("foxglove"),
        ),
    )


@contextmanager
def foxglove_on(options: argparse.Namespace, session: Session) -> Iterator[None]:
    """Serve the topics of a session: those of a robot from another process."""
    if options.attach:
        with foxglove_process(options):
            yield
        return
    from bt_mission.commands.foxglove.server import FoxgloveServer
    from bt_mission.ros.graph import quiet_node

    node = quiet_node("bt_mission_foxglove", session.node.context)
    try:
        server = FoxgloveServer(node, _port_of(options), lambda: session.now_ns, to_stderr)
    except BaseException:
        node.destroy_node()
        raise
    with closing(server):
        _announce(server)
        session.attach(server)
        try:
            yield
        finally:
            session.detach(server)


@contextmanager
def foxglove_process(options: argparse.Namespace) -> Iterator[None]:
    """Another process that serves the graph of this one.

    A robot's executive serves no viewers itself, so their failures do not affect it.
    """
    from bt_mission.commands.foxglove.server import listen

    number = _port_of(options)
    listen(number).close()  # or say so at once
    with watch_beside("--foxglove", f"--foxglove-port={number}"):
        yield


def serve_graph(options: argparse.Namespace) -> int:
    """Serve the topics of the graph until interrupted; return the exit code."""
    from bt_mission.base.dds.publishers import CLOCK
    from bt_mission.commands.foxglove.server import FoxgloveServer
    from bt_mission.ros.graph_session import GraphSession

    with GraphSession() as graph:
        node = graph.node

        def now_ns() -> int:
            return int(node.get_clock().now().nanoseconds)

        has_clock = False
        with closing(FoxgloveServer(node, _port_of(options), now_ns, to_stderr)) as server:
            _announce(server)
            while not (graph.interrupts.count or server.is_broken):
                if options.until_input_ends and has_input_ended():
                    return SUCCESS
                graph.step()
                server.after_step()
                if not has_clock and node.count_publishers(CLOCK):
                    has_clock = True
                    graph.follow_clock()
    return INTERRUPTED


def _port_of(options: argparse.Namespace) -> int:
    from bt_mission.commands.foxglove.server import PORT

    number: int = PORT if options.foxglove_port is None else options.foxglove_port
    return number


def _announce(server: FoxgloveServer) -> None:
    from bt_mission.commands.foxglove import LAYOUT

    to_stderr(f"in Foxglove: {server.link}, layout {LAYOUT}")


ADDITION = ShowAddition(
    foxglove_options,
    lambda options: bool(getattr(options, "foxglove", False)),
    foxglove_on,
    foxglove_process,
    serve_graph,
)
