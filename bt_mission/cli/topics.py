"""``bt-mission topics``: what is said in a graph, and how often."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from bt_mission.cli.exits import INTERRUPTED, SUCCESS
from bt_mission.cli.hand_options import (
    add_graph_options,
    add_json_option,
    count,
    joined,
    print_found,
    subcommands,
)

if TYPE_CHECKING:
    from bt_mission.graph_tools.graph_session import GraphSession

EPILOG = """\
examples:
  bt-mission topics list
  bt-mission topics echo /odom --field pose.pose.position
  bt-mission topics echo /map --once
  bt-mission topics hz /scan
"""


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    kinds = subcommands(commands, "topics", "list topics, show their messages and rates", EPILOG)
    lists = kinds.add_parser("list", help="the topics of the graph, with publishers > subscribers")
    lists.add_argument("--all", action="store_true", help="hidden ones, too: those of actions")
    add_graph_options(lists, "topics")
    add_json_option(lists, "one list of objects")
    lists.set_defaults(command=list_topics)

    echo_ = kinds.add_parser(
        "echo",
        help="print messages as YAML",
        description="Prints messages as YAML, lists cut after 16 items. Suits whatever quality of "
        "service the publishers offer, and brings what was said before of latched topics.",
    )
    _add_topic(echo_)
    amount = echo_.add_mutually_exclusive_group()
    amount.add_argument("--once", action="store_const", const=1, dest="count", help="one message")
    amount.add_argument("--count", type=count, metavar="N", help="so many messages")
    echo_.add_argument("--field", help="only this field, by its dotted name")
    echo_.add_argument("--full", action="store_true", help="whole lists")
    add_json_option(echo_, "a message a line, whole")
    echo_.set_defaults(command=echo)

    rate = kinds.add_parser(
        "hz",
        help="how often messages come",
        description="Prints each second how often messages come, by this machine's clock, or by "
        "/clock with --sim-time.",
    )
    _add_topic(rate)
    rate.add_argument(
        "--window",
        type=count,
        default=1000,
        metavar="N",
        help="messages over which the rate is taken (default: 1000)",
    )
    rate.add_argument("--count", type=count, metavar="N", help="leave after so many lines")
    rate.add_argument("--sim-time", action="store_true", help="seconds of /clock")
    add_json_option(rate, "an object a line")
    rate.set_defaults(command=hz)


def _add_topic(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("topic", help="name of the topic, such as /odom")
    parser.add_argument(
        "--type", metavar="TYPE", help="its type, instead of the one found in the graph"
    )
    add_graph_options(parser, "the topic")


def list_topics(options: argparse.Namespace) -> int:
    """Print the topics of the graph."""
    from bt_mission.graph_tools import graph_query, listing

    with joined(options) as hand:
        graph_query.query_graph(hand, options.wait)
        found = graph_query.topics(hand.node, hidden=options.all)
    objects = [listing.entry_object(one, "publishers", "subscribers") for one in found]
    print_found(options, "topics", listing.topic_rows(found), objects)
    return SUCCESS


def echo(options: argparse.Namespace) -> int:
    """Print messages until there are enough, or until Ctrl-C."""
    from bt_mission.graph_tools.echo import Echo
    from bt_mission.graph_tools.listening import Listener

    with joined(options) as hand:
        name, type_name = _named(hand, options)
        shown = Echo(type_name, options.field, full=options.full or options.json, json=options.json)
        listener = Listener(hand, name, type_name, shown.take)
        left = options.count
        while not hand.interrupts:
            listener.step()
            for text in shown.texts(left):
                print(text, flush=True)
                left = None if left is None else left - 1
            if left == 0:
                return SUCCESS
    return INTERRUPTED


def hz(options: argparse.Namespace) -> int:
    """Print the rate each second until Ctrl-C."""
    from bt_mission.graph_tools.rate_lines import RateLines

    with joined(options) as hand:
        name, type_name = _named(hand, options)
        lines = RateLines(
            hand, name, type_name, options.window, sim_time=options.sim_time, json=options.json
        )
        left = options.count
        while not hand.interrupts:
            line = lines.step()
            if line:
                print(line, flush=True)
                left = None if left is None else left - 1
            if left == 0:
                return SUCCESS
    return INTERRUPTED


def _named(hand: GraphSession, options: argparse.Namespace) -> tuple[str, str]:
    from bt_mission.graph_tools import graph_query
    from bt_mission.ros.interface_types import message_type

    name = graph_query.resolved(hand.node, "topic", options.topic)
    if options.type:
        message_type(options.type)
        return name, options.type
    return name, graph_query.type_of(hand, "topic", name, options.wait)
