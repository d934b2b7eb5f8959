"""``bt-mission topics``: the messages of a graph and their rates."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from bt_mission.cli.argument_types import count
from bt_mission.cli.exits import INTERRUPTED, SUCCESS
from bt_mission.cli.parser import Command, Option, each
from bt_mission.commands.graph import graph_command

if TYPE_CHECKING:
    from bt_mission.ros.graph_session import GraphSession

EPILOG = """\
examples:
  bt-mission topics list
  bt-mission topics echo /odom --field pose.pose.position
  bt-mission topics echo /map --once
  bt-mission topics hz /scan
"""


def echo(options: argparse.Namespace) -> int:
    """Print messages until there are enough, or until Ctrl-C."""
    from bt_mission.commands.graph.topic_messages import MessageTexts, TopicSubscriber

    with graph_command.joined(options) as session:
        name, type_name = graph_command.named("topic", session, options)
        shown = MessageTexts(type_name, options.field, full=options.full, json=options.json)
        subscriber = TopicSubscriber(session, name, type_name, shown.take)

        def step(left: int | None) -> Iterable[str]:
            subscriber.step()
            return shown.texts(left)

        return _print_until(session, step, 1 if options.once else options.count)


def hz(options: argparse.Namespace) -> int:
    """Print the rate each second until Ctrl-C."""
    from bt_mission.commands.graph.topic_messages import RateLines

    with graph_command.joined(options) as session:
        name, type_name = graph_command.named("topic", session, options)
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


_TOPIC = (
    graph_command.name_option("topic", "/odom"),
    graph_command.type_option(),
    *graph_command.graph_options("the topic"),
)

COMMANDS = {
    "topics": graph_command.graph_command(
        "topics",
        {
            "list": graph_command.list_command(
                "topic", "list the topics of the graph, with publishers > subscribers"
            ),
            "echo": Command(
                echo,
                "Prints messages as YAML, with lists cut after 16 items. Adapts to the quality "
                "of service of the publishers, and also prints earlier messages of latched topics.",
                (
                    *_TOPIC,
                    Option("--once", "print one message and exit"),
                    Option("--count N", "print N messages and exit", count, excludes=each("once")),
                    Option("--field FIELD", "print only this field, by its dotted name"),
                    Option("--full", "print lists in full"),
                    graph_command.json_option("one message per line, uncut"),
                ),
                help="print messages as YAML",
                leaves_at_once=True,
            ),
            "hz": Command(
                hz,
                "Prints the rate of messages every second, by this machine's clock, or by /clock "
                "with --sim-time.",
                (
                    *_TOPIC,
                    Option(
                        "--window N",
                        "number of messages over which to average (default: 1000)",
                        count,
                        1000,
                    ),
                    Option("--count N", "exit after N lines", count),
                    Option("--sim-time", "use the time of /clock"),
                    graph_command.json_option("one object per line"),
                ),
                help="show the rate of messages",
                leaves_at_once=True,
            ),
        },
        EPILOG,
    )
}
