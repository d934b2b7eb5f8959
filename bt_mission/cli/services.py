"""``bt-mission services``: what a graph can be asked, and asking it."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from bt_mission.cli.exits import ABORTED, LOST, SUCCESS
from bt_mission.cli.hand_options import (
    WAIT_S,
    add_graph_options,
    add_json_option,
    joined,
    print_found,
    seconds,
    subcommands,
)

EPILOG = """\
examples:
  bt-mission services list
  bt-mission services call /stop
  bt-mission services call /motor_power 'data: false'

exit codes of call: 0 answered, 1 answered with success: false, 2 bad input, 5 no server,
6 no answer
"""


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    kinds = subcommands(commands, "services", "list and call services", EPILOG)
    lists = kinds.add_parser("list", help="the services of the graph")
    lists.add_argument("--all", action="store_true", help="hidden ones, too: those of actions")
    add_graph_options(lists, "services")
    add_json_option(lists, "one list of objects")
    lists.set_defaults(command=list_services)

    call_ = kinds.add_parser("call", help="call a service and print its answer")
    call_.add_argument("service", help="name of the service, such as /stop")
    call_.add_argument(
        "request",
        nargs="?",
        default="",
        help="fields of the request in YAML, such as 'data: true'; - reads standard input",
    )
    call_.add_argument(
        "--type", metavar="TYPE", help="its type, instead of the one found in the graph"
    )
    call_.add_argument(
        "--timeout",
        type=seconds,
        default=WAIT_S,
        metavar="SECONDS",
        help=f"how long to wait for the answer (default: {WAIT_S:g})",
    )
    add_graph_options(call_, "a server")
    add_json_option(call_, "one object")
    call_.set_defaults(command=call, late="request")


def list_services(options: argparse.Namespace) -> int:
    """Print the services of the graph."""
    from bt_mission.graph_tools import graph_query, listing

    with joined(options) as hand:
        graph_query.query_graph(hand, options.wait)
        found = graph_query.services(hand.node, hidden=options.all)
    objects = [{"name": one.name, "types": list(one.types)} for one in found]
    print_found(options, "services", listing.service_rows(found), objects)
    return SUCCESS


def call(options: argparse.Namespace) -> int:
    """Call a service and print its answer."""
    from bt_mission.graph_tools import graph_query
    from bt_mission.graph_tools.calling import Silence, ask
    from bt_mission.graph_tools.values import as_json, as_yaml, plain

    text = sys.stdin.read() if options.request == "-" else options.request
    with joined(options) as hand:
        name = graph_query.resolved(hand.node, "service", options.service)
        type_name = options.type or graph_query.type_of(hand, "service", name, options.wait)
        try:
            answer = ask(
                hand, name, type_name, text, server_s=options.wait, answer_s=options.timeout
            )
        except Silence as silence:
            print(silence, file=sys.stderr)
            return LOST
    shown = plain(answer)
    print(as_json(shown) if options.json else as_yaml(shown), end="\n" if options.json else "")
    return ABORTED if getattr(answer, "success", True) is False else SUCCESS
