"""``bt-mission actions``: goals sent, cancelled and watched by hand."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Mapping
from contextlib import closing
from typing import TYPE_CHECKING, Any

from bt_mission.cli.exits import (
    ABORTED,
    CANCELED,
    INTERRUPTED,
    LOST,
    NO_SERVER,
    REJECTED,
    SUCCESS,
)
from bt_mission.cli.hand_options import (
    add_graph_options,
    add_json_option,
    joined,
    print_found,
    seconds,
    subcommands,
)
from bt_mission.core.errors import BtMissionError

if TYPE_CHECKING:
    from bt_mission.graph_tools.goal_request import GoalOutcome
    from bt_mission.graph_tools.graph_session import GraphSession
    from bt_mission.graph_tools.interface_description import InterfaceDescription
    from bt_mission.graph_tools.sending import Sender

EPILOG = """\
examples:
  bt-mission actions list
  bt-mission actions info /turn
  bt-mission actions send /turn 'angle: 90'
  bt-mission actions send /turn --form
  bt-mission actions watch /turn
  bt-mission actions cancel /turn

exit codes of send: 0 succeeded, 1 aborted, 2 bad input, 3 rejected, 4 canceled, 5 no server,
6 lost or not confirmed, 130 left by a second Ctrl-C; of cancel: 0 all ended, 3 refused, 5, 6
"""
GOAL = "fields of the goal in YAML, such as 'angle: 90'; - reads standard input (default: {})"


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    kinds = subcommands(commands, "actions", "list, send, cancel and watch goals by hand", EPILOG)
    _add_list(kinds)
    _add_info(kinds)
    _add_send(kinds)
    _add_cancel(kinds)
    _add_watch(kinds)


def _add_list(kinds: Any) -> None:
    parser = kinds.add_parser("list", help="the actions of the graph, and who serves them")
    add_graph_options(parser, "actions")
    add_json_option(parser, "one list of objects")
    parser.set_defaults(command=list_actions)


def _add_info(kinds: Any) -> None:
    parser = kinds.add_parser(
        "info", help="an action's nodes and the fields of its messages, with units and comments"
    )
    parser.add_argument("action", help="name of the action, such as /turn")
    _add_type(parser)
    add_graph_options(parser, "the action")
    add_json_option(parser, "one object")
    parser.set_defaults(command=info)


def _add_send(kinds: Any) -> None:
    parser = kinds.add_parser(
        "send",
        help="send a goal and see it to its end",
        description="Sends a goal and shows its feedback until it has ended. Ctrl-C cancels the "
        "goal and waits for its end, for 10 s at most; a second Ctrl-C leaves at once and says "
        "which goal it left.",
        epilog=EPILOG.partition("\n\n")[2],
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("action", help="name of the action, such as /turn")
    parser.add_argument("goal", nargs="?", default="", help=GOAL)
    _add_type(parser)
    parser.add_argument(
        "--form", action="store_true", help="fill the goal in field by field, on a terminal"
    )
    parser.add_argument(
        "--timeout", type=seconds, metavar="SECONDS", help="cancel the goal after this time"
    )
    add_graph_options(parser, "a server")
    parser.add_argument(
        "--plain", action="store_true", help="plain lines, also when the output is a terminal"
    )
    add_json_option(parser, "an object a line for each thing that happens")
    parser.set_defaults(command=send, late="goal")


def _add_cancel(kinds: Any) -> None:
    parser = kinds.add_parser(
        "cancel",
        help="cancel goals, also those of others, and wait for their end",
        description="Cancels every goal of an action, or one, whoever sent it, and waits for "
        "their end, for 10 s at most.",
    )
    parser.add_argument("action", help="name of the action, such as /turn")
    parser.add_argument(
        "goal", nargs="?", default="", help="the goal's id, or its first digits (default: all)"
    )
    _add_type(parser)
    add_graph_options(parser, "a server")
    parser.set_defaults(command=cancel, late="goal")


def _add_watch(kinds: Any) -> None:
    parser = kinds.add_parser(
        "watch",
        help="show the goals of an action and their feedback, whoever sent them",
        description="Shows what becomes of each goal of an action, and its feedback, until Ctrl-C.",
    )
    parser.add_argument("action", help="name of the action, such as /turn")
    _add_type(parser)
    add_graph_options(parser, "the action")
    add_json_option(parser, "an object a line")
    parser.set_defaults(command=watch)


def _add_type(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--type", help="the action's type, instead of the one found in the graph", metavar="TYPE"
    )


def list_actions(options: argparse.Namespace) -> int:
    """Print the actions of the graph."""
    from bt_mission.graph_tools import graph_query, listing

    with joined(options) as hand:
        graph_query.query_graph(hand, options.wait)
        found = graph_query.actions(hand.node)
    objects = [listing.entry_object(one, "servers", "clients") for one in found]
    print_found(options, "actions", listing.action_rows(found), objects)
    return SUCCESS


def info(options: argparse.Namespace) -> int:
    """Print all that is known of an action."""
    from bt_mission.graph_tools import graph_query, listing
    from bt_mission.graph_tools.interface_description import describe_interface
    from bt_mission.graph_tools.values import as_json

    with joined(options) as hand:
        name, type_name = _named(hand, options)
        graph_query.query_graph(hand, options.wait)
        found = {one.name: one for one in graph_query.actions(hand.node)}
        entry = found.get(name, graph_query.GraphEntry(name, (type_name,)))
    known = describe_interface(type_name)
    if options.json:
        print(as_json(listing.info_object(entry, known)))
        return SUCCESS
    for line in listing.info_lines(entry, known):
        print(line)
    return SUCCESS


def send(options: argparse.Namespace) -> int:
    """Send a goal and see it to its end."""
    from bt_mission.graph_tools.interface_description import describe_interface
    from bt_mission.graph_tools.sending import Sender, audience_for, see_through
    from bt_mission.graph_tools.yaml_text import read_fields

    if options.form:
        _refuse_form(options)
    text = sys.stdin.read() if options.goal == "-" else options.goal
    with joined(options) as hand:
        name, type_name = _named(hand, options)
        known = describe_interface(type_name)
        fields = read_fields(text, known.part("goal").shape, "goal")
        sender = Sender(hand, name, type_name)
        if options.form:
            return _fill_in(hand, sender, known, name, fields, options)
        request = sender.prepare(fields)
        audience = audience_for(sys.stdout, known, request, json=options.json, plain=options.plain)
        goal = sender.open(request, audience, server_s=options.wait, limit_s=options.timeout)
        return _code(see_through(hand, goal).how)


def _fill_in(
    hand: GraphSession,
    sender: Sender,
    known: InterfaceDescription,
    name: str,
    fields: Mapping[str, Any],
    options: argparse.Namespace,
) -> int:
    """Send goals from a form; gives the code of the last one."""
    from bt_mission.graph_tools.form import GoalForm

    form = GoalForm(
        hand,
        sender,
        known,
        name,
        fields,
        server_s=options.wait,
        encoding=sys.stdout.encoding,
    )
    end = form.run()
    for line in form.drain:
        print(line)
    return SUCCESS if end is None else _code(end.how)


def _refuse_form(options: argparse.Namespace) -> None:
    """Refuse what does not go with a form.

    :raises BtMissionError: with what to do instead.
    """
    if not (sys.stdin.isatty() and sys.stdout.isatty()) or os.environ.get("TERM") == "dumb":
        raise BtMissionError("--form needs a terminal; give the goal as YAML instead")
    if options.json or options.timeout is not None:
        raise BtMissionError("--form goes with neither --json nor --timeout")


def cancel(options: argparse.Namespace) -> int:
    """Cancel goals and wait for their end."""
    from bt_mission.graph_tools.canceling import cancel_goals

    with joined(options) as hand:
        name, _ = _named(hand, options)
        done = cancel_goals(hand, name, options.goal, print, server_s=options.wait)
        return SUCCESS if done.all_ended else LOST if done.all_taken else REJECTED


def watch(options: argparse.Namespace) -> int:
    """Show the goals of an action until Ctrl-C."""
    from bt_mission.graph_tools.interface_description import describe_interface
    from bt_mission.graph_tools.watch_views import watch_view
    from bt_mission.graph_tools.watching import GoalWatch

    with joined(options) as hand:
        name, type_name = _named(hand, options)
        with closing(
            watch_view(sys.stdout, describe_interface(type_name), json=options.json)
        ) as view:
            GoalWatch(hand, name, type_name, view)
            while not hand.interrupts:
                hand.step()
                view.flush()
    return INTERRUPTED


def _named(hand: GraphSession, options: argparse.Namespace) -> tuple[str, str]:
    """The action's full name and its type, from the graph where it is not given."""
    from bt_mission.graph_tools import graph_query
    from bt_mission.ros.interface_types import action_type

    name = graph_query.resolved(hand.node, "action", options.action)
    if options.type:
        action_type(options.type)
        return name, options.type
    return name, graph_query.type_of(hand, "action", name, options.wait)


def _code(how: GoalOutcome) -> int:
    from bt_mission.graph_tools.goal_request import GoalOutcome

    codes = {
        GoalOutcome.SUCCEEDED: SUCCESS,
        GoalOutcome.ABORTED: ABORTED,
        GoalOutcome.CANCELED: CANCELED,
        GoalOutcome.REJECTED: REJECTED,
        GoalOutcome.NO_SERVER: NO_SERVER,
        GoalOutcome.NOT_SENT: INTERRUPTED,
        GoalOutcome.LEFT: INTERRUPTED,
    }
    return codes.get(how, LOST)
