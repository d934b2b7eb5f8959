"""What the commands ``actions``, ``topics`` and ``services`` have in common."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from bt_mission.cli.argument_types import seconds
from bt_mission.cli.commands import COMMANDS
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.network import add_network_option, prepare_graph
from bt_mission.core.text import columns

if TYPE_CHECKING:
    from bt_mission.graph_tools.graph_query import Kind
    from bt_mission.graph_tools.graph_session import GraphSession

WAIT_S = 5.0


def subcommands(commands: Any, name: str, epilog: str) -> Any:
    """Add a command that has commands of its own."""
    words = COMMANDS[name].help
    parser = commands.add_parser(
        name,
        description=f"{words[0].upper()}{words[1:]}. Works with any ROS 2 graph, and with every "
        "type that is installed.",
        epilog=epilog,
    )
    return parser.add_subparsers(metavar="what")


def add_list(kinds: Any, kind: Kind, words: str) -> None:
    """Add the command that lists what there is of a kind."""
    parser = kinds.add_parser("list", help=words)
    if kind != "action":
        parser.add_argument("--all", action="store_true", help="hidden ones, too: those of actions")
    add_graph_options(parser, f"{kind}s")
    add_json_option(parser, "one list of objects")
    parser.set_defaults(command=list_entries, kind=kind, all=False)


def add_name(parser: argparse.ArgumentParser, kind: Kind, example: str) -> None:
    """Add the name of what a command is about."""
    parser.add_argument(kind, help=f"name of the {kind}, such as {example}")
    parser.set_defaults(kind=kind)


def add_type(parser: argparse.ArgumentParser, whose: str = "its") -> None:
    """Add the type of what a command is about."""
    words = f"{whose} type, instead of the one found in the graph"
    parser.add_argument("--type", metavar="TYPE", help=words)


def add_graph_options(parser: argparse.ArgumentParser, what: str) -> None:
    """Add where to look, and for how long."""
    parser.add_argument("--namespace", default="", help="of names without a leading slash")
    add_network_option(parser)
    parser.add_argument(
        "--wait",
        type=seconds,
        default=WAIT_S,
        metavar="SECONDS",
        help=f"how long to look for {what} (default: {WAIT_S:g})",
    )


def add_json_option(parser: argparse.ArgumentParser, what: str) -> None:
    """Add the output for programs."""
    parser.add_argument("--json", action="store_true", help=f"for programs: {what}")


@contextmanager
def joined(options: argparse.Namespace) -> Iterator[GraphSession]:
    """Take part in the graph."""
    from bt_mission.cli.run import leaving_at_once

    with leaving_at_once():
        prepare_graph(options)
        from bt_mission.graph_tools.graph_session import GraphSession

        with GraphSession(options.namespace) as session:
            yield session


def list_entries(options: argparse.Namespace) -> int:
    """Print what the graph has of a kind: a table, or a list of objects; or that it is none."""
    from bt_mission.graph_tools import listing
    from bt_mission.graph_tools.graph_query import entries, query_graph
    from bt_mission.graph_tools.values import as_json

    kind = options.kind
    with joined(options) as session:
        query_graph(session, options.wait)
        found = entries(session.node, kind, hidden=options.all)
    if options.json:
        lines = [as_json([listing.entry_object(kind, one) for one in found])]
    else:
        lines = columns(listing.entry_rows(kind, found)) if found else []
    if not found:
        print(f"no {kind}s in the graph (looked for {options.wait:g} s)", file=sys.stderr)
    for line in lines:
        print(line)
    return SUCCESS


def named(session: GraphSession, options: argparse.Namespace) -> tuple[str, str]:
    """The full name of what a command is about, and its type: the graph's where none is given."""
    from bt_mission.graph_tools.graph_query import resolved, type_of
    from bt_mission.ros.interface_types import action_type, message_type, service_type

    kind: Kind = options.kind
    name = resolved(session.node, kind, getattr(options, kind))
    if not options.type:
        return name, type_of(session, kind, name, options.wait)
    {"action": action_type, "topic": message_type, "service": service_type}[kind](options.type)
    return name, options.type
