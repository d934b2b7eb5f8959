"""What the commands ``actions``, ``topics`` and ``services`` have in common."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING

from bt_mission.base.commands import row_of
from bt_mission.base.text import columns
from bt_mission.cli.argument_types import seconds
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.options import JSON, NAMESPACE, NETWORK, prepare_graph
from bt_mission.cli.parser import Command, Option

if TYPE_CHECKING:
    from bt_mission.commands.graph.graph_query import Kind
    from bt_mission.ros.graph_session import GraphSession

WAIT_S = 5.0


def graph_command(name: str, commands: Mapping[str, Command], epilog: str) -> Command:
    """Return a command with subcommands."""
    words = row_of(name).help
    description = (
        f"{words[0].upper()}{words[1:]}. Works with any ROS 2 graph and all installed types."
    )
    return Command(None, description, epilog=epilog, commands=commands)


def list_command(kind: Kind, words: str) -> Command:
    """Return the command that lists what there is of a kind."""
    hidden = Option("--all", "include hidden ones, those of actions")
    return Command(
        partial(list_entries, kind),
        options=(
            *([] if kind == "action" else [hidden]),
            *graph_options(f"{kind}s"),
            json_option("one list of objects"),
        ),
        help=words,
        leaves_at_once=True,
    )


def name_option(kind: Kind, example: str) -> Option:
    """Return the name of what a command is about."""
    return Option(kind, f"name of the {kind}, such as {example}", completes=f"{kind}s")


def type_option(whose: str = "its") -> Option:
    """Return the type of what a command is about."""
    return Option("--type TYPE", f"{whose} type (default: as found in the graph)")


def graph_options(what: str) -> tuple[Option, ...]:
    """Return where to look, and for how long."""
    wait = f"how long to look for {what} (default: {WAIT_S:g})"
    return (
        NAMESPACE.but(help="namespace of names without a leading slash"),
        NETWORK,
        Option("--wait SECONDS", wait, seconds, WAIT_S),
    )


def json_option(what: str) -> Option:
    """Return the output for programs."""
    return JSON.but(help=f"print JSON: {what}")


@contextmanager
def joined(options: argparse.Namespace) -> Iterator[GraphSession]:
    """Take part in the graph."""
    prepare_graph(options)
    from bt_mission.ros.graph_session import GraphSession

    with GraphSession(options.namespace) as session:
        yield session


def list_entries(kind: Kind, options: argparse.Namespace) -> int:
    """Print the entries of a kind in the graph as a table or a list of objects."""
    from bt_mission.commands.graph import listing
    from bt_mission.commands.graph.graph_query import entries, query_graph
    from bt_mission.commands.graph.values import as_json

    with joined(options) as session:
        query_graph(session, options.wait)
        listed_entries = entries(session.node, kind, hidden=getattr(options, "all", False))
    if options.json:
        lines = [as_json([listing.entry_object(kind, entry) for entry in listed_entries])]
    else:
        lines = columns(listing.entry_rows(kind, listed_entries)) if listed_entries else []
    if not listed_entries:
        print(f"no {kind}s in the graph (looked for {options.wait:g} s)", file=sys.stderr)
    for line in lines:
        print(line)
    return SUCCESS


def named(kind: Kind, session: GraphSession, options: argparse.Namespace) -> tuple[str, str]:
    """The full name of what a command is about, and its type: the graph's where none is given."""
    from bt_mission.commands.graph.graph_query import resolved, type_of
    from bt_mission.ros.interface_types import action_type, message_type, service_type

    name = resolved(session.node, kind, getattr(options, kind))
    if not options.type:
        return name, type_of(session, kind, name, options.wait)
    {"action": action_type, "topic": message_type, "service": service_type}[kind](options.type)
    return name, options.type
