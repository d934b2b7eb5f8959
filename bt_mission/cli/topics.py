"""``bt-mission topics``: what is said in a graph, and how often."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from bt_mission.cli import graph_command
from bt_mission.cli.argument_types import count
from bt_mission.cli.exits import INTERRUPTED, SUCCESS

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
    kinds = graph_command.subcommands(commands, "topics", EPILOG)
    graph_command.add_list(kinds, "topic", "the topics of the graph, with publishers > subscribers")

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
    graph_command.add_json_option(echo_, "a message a line, whole")
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
    graph_command.add_json_option(rate, "an object a line")
    rate.set_defaults(command=hz)


def _add_topic(parser: argparse.ArgumentParser) -> None:
    graph_command.add_name(parser, "topic", "/odom")
    graph_command.add_type(parser)
    graph_command.add_graph_options(parser, "the topic")


def echo(options: argparse.Namespace) -> int:
    """Print messages until there are enough, or until Ctrl-C."""
    from bt_mission.graph_tools.topic_messages import MessageTexts, TopicSubscriber

    with graph_command.joined(options) as session:
        name, type_name = graph_command.named(session, options)
        shown = MessageTexts(type_name, options.field, full=options.full, json=options.json)
        subscriber = TopicSubscriber(session, name, type_name, shown.take)

        def step(left: int | None) -> Iterable[str]:
            subscriber.step()
            return shown.texts(left)

        return _print_until(session, step, options.count)


def hz(options: argparse.Namespace) -> int:
    """Print the rate each second until Ctrl-C."""
    from bt_mission.graph_tools.topic_rate import RateLines

    with graph_command.joined(options) as session:
        name, type_name = graph_command.named(session, options)
        lines = RateLines(
            session, name, type_name, options.window, sim_time=options.sim_time, json=options.json
        )
        return _print_until(session, lambda _: lines.step(), options.count)


def _print_until(
    session: GraphSession, step: Callable[[int | None], Iterable[str]], count: int | None
) -> int:
    """Print what each step gives until there is enough, or until Ctrl-C."""
    left = count
    while not session.interrupts.count:
        for text in step(left):
            print(text, flush=True)
            left = None if left is None else left - 1
        if left == 0:
            return SUCCESS
    return INTERRUPTED
