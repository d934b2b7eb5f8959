"""The options of commands that show a mission in Foxglove or Lichtblick, and what they do."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import closing, contextmanager
from typing import TYPE_CHECKING

from bt_mission.cli.exits import INTERRUPTED, SUCCESS
from bt_mission.cli.web import (
    has_input_ended,
    port_number,
    refuse_without_server,
    to_stderr,
    watch_beside,
)
from bt_mission.core.errors import BtMissionError

if TYPE_CHECKING:
    from bt_mission.graph_tools.foxglove.server import FoxgloveServer
    from bt_mission.sessions.session import ObservableSession


def add_foxglove_options(parser: argparse.ArgumentParser) -> None:
    """Are topics served to Foxglove?"""
    group = parser.add_argument_group("in Foxglove or Lichtblick")
    group.add_argument(
        "--foxglove",
        action="store_true",
        help="serve all topics to Foxglove and Lichtblick on this machine, and print the address "
        "to connect to",
    )
    group.add_argument(
        "--foxglove-port",
        type=port_number,
        metavar="N",
        help="with --foxglove: listen on this port (default: 8765; 0 takes any that is free)",
    )


def refuse_foxglove(options: argparse.Namespace, *, instead: tuple[str, ...] = ()) -> None:
    """Refuse what cannot be served, before anything moves.

    Args:
        instead: Names of options that show something else.

    Raises:
        BtMissionError: With what to do.
    """
    if not options.foxglove:
        if options.foxglove_port is not None:
            raise BtMissionError("--foxglove-port goes with --foxglove")
        return
    for name in instead:
        if getattr(options, name):
            raise BtMissionError(f"--foxglove and --{name}: choose one of them")
    refuse_without_server("--foxglove")


@contextmanager
def foxglove_on(options: argparse.Namespace, session: ObservableSession) -> Iterator[None]:
    """Serve the topics of a session, if that is wanted: those of a robot from another process."""
    if not options.foxglove or options.attach:
        with foxglove_process(options):
            yield
        return
    from bt_mission.graph_tools.foxglove.server import FoxgloveServer
    from bt_mission.ros.graph import quiet_node

    node = quiet_node("bt_mission_foxglove", session.node.context)
    try:
        server = FoxgloveServer(node, _port_of(options), lambda: session.now_ns, to_stderr)
    except BaseException:
        node.destroy_node()
        raise
    with closing(server):
        _announce(server)
        session.add_observer(server)
        try:
            yield
        finally:
            session.remove_observer(server)


@contextmanager
def foxglove_process(options: argparse.Namespace) -> Iterator[None]:
    """Another process that serves the graph of this one, if that is wanted.

    A robot's executive serves no viewer itself: whatever happens to one, it goes on.
    """
    if not options.foxglove:
        yield
        return
    from bt_mission.graph_tools.foxglove.server import listen

    port = _port_of(options)
    listen(port).close()  # or say so at once
    with watch_beside("--foxglove", f"--foxglove-port={port}"):
        yield


def serve_graph(options: argparse.Namespace) -> int:
    """Serve the topics of the graph until told to leave; gives the exit code."""
    from bt_mission.core.dds.publishers import CLOCK
    from bt_mission.graph_tools.foxglove.server import FoxgloveServer
    from bt_mission.graph_tools.graph_session import GraphSession

    with GraphSession() as graph:
        node = graph.node
        port = _port_of(options)

        def now_ns() -> int:
            return int(node.get_clock().now().nanoseconds)

        has_clock = False
        with closing(FoxgloveServer(node, port, now_ns, to_stderr)) as server:
            _announce(server)
            while not (graph.interrupts.count or server.is_broken):
                if options.until_input_ends and has_input_ended():
                    return SUCCESS
                graph.step()
                server.look()
                if not has_clock and node.count_publishers(CLOCK):
                    has_clock = True
                    graph.follow_clock()
    return INTERRUPTED


def _port_of(options: argparse.Namespace) -> int:
    from bt_mission.graph_tools.foxglove.server import PORT

    port: int = PORT if options.foxglove_port is None else options.foxglove_port
    return port


def _announce(server: FoxgloveServer) -> None:
    from bt_mission.graph_tools.foxglove import LAYOUT

    to_stderr(f"in Foxglove: {server.link}, layout {LAYOUT}")
