"""``bt-mission actions``: goals sent, cancelled and watched by hand."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Mapping
from contextlib import closing
from shlex import quote
from typing import TYPE_CHECKING, Any

from bt_mission.base.errors import BtMissionError
from bt_mission.base.text import columns
from bt_mission.cli.argument_types import seconds
from bt_mission.cli.exits import ABORTED, CANCELED, INTERRUPTED, LOST, NO_SERVER, REJECTED, SUCCESS
from bt_mission.cli.options import PLAIN
from bt_mission.cli.parser import Command, Option, each
from bt_mission.commands.graph import graph_command

if TYPE_CHECKING:
    from bt_mission.commands.graph.goal_events import GoalOutcome
    from bt_mission.commands.graph.goal_request import GoalSender
    from bt_mission.commands.graph.interface_description import InterfacePart
    from bt_mission.ros.graph_session import GraphSession

EPILOG = """\
examples:
  bt-mission actions list
  bt-mission actions info /turn
  bt-mission actions send /turn 'angle: 90'
  bt-mission actions send /turn --form
  bt-mission actions watch /turn
  bt-mission actions cancel /turn

exit codes of send: 0 succeeded, 1 aborted, 2 bad input, 3 rejected, 4 canceled, 5 no server,
6 lost or not confirmed, 130 a second Ctrl-C; of cancel: 0 all ended, 3 refused, 5 and 6 as for send
"""
GOAL = (
    "fields of the goal in YAML, such as 'angle: 90'; {} sends all defaults, - reads standard input"
)


def info(options: argparse.Namespace) -> int:
    """Print type, fields, servers and clients of an action."""
    from bt_mission.commands.graph import graph_query, listing
    from bt_mission.commands.graph.interface_description import describe_interface
    from bt_mission.commands.graph.values import as_json

    with graph_command.joined(options) as session:
        name, type_name = graph_command.named("action", session, options)
        graph_query.query_graph(session, options.wait)
        known_actions = {
            action.name: action for action in graph_query.entries(session.node, "action")
        }
        entry = known_actions.get(name, graph_query.GraphEntry(name, (type_name,)))
    known = describe_interface(type_name)
    if options.json:
        print(as_json(listing.info_object(entry, known)))
    else:
        print("\n".join(listing.info_lines(entry, known)))
    return SUCCESS


def send(options: argparse.Namespace) -> int:
    """Send a goal and wait until it ends."""
    from bt_mission.commands.graph.goal_request import GoalSender, step_to_end
    from bt_mission.commands.graph.goal_views import goal_view_for
    from bt_mission.commands.graph.interface_description import describe_interface
    from bt_mission.commands.graph.values import read_fields

    text = sys.stdin.read() if options.goal == "-" else options.goal
    with graph_command.joined(options) as session:
        name, type_name = graph_command.named("action", session, options)
        part = describe_interface(type_name).part("goal")
        if not (text.strip() or options.form):
            _refuse_nothing(name, part)
        fields = read_fields(text, part.shape, "goal")
        sender = GoalSender(
            session, name, type_name, server_s=options.wait, limit_s=options.timeout
        )
        if options.form:
            return _fill_in(session, sender, fields)
        message = sender.prepare(fields)
        view = goal_view_for(
            sys.stdout, sender.about, message, json=options.json, plain=options.plain
        )
        with closing(view):
            return _code(step_to_end(session, sender.open(message, view.show)).how)


def _fill_in(session: GraphSession, sender: GoalSender, fields: Mapping[str, Any]) -> int:
    """Send goals from a form; gives the code of the last one."""
    from bt_mission.commands.graph.form import GoalFormApp

    form = GoalFormApp(session, sender, fields, encoding=sys.stdout.encoding)
    end = form.run()
    for line in form.last_words:
        print(line)
    return SUCCESS if end is None else _code(end.how)


def _refuse_nothing(name: str, part: InterfacePart) -> None:
    """Refuse to send a goal without being given one, where it has fields.

    Raises:
        BtMissionError: With the fields, and an example.
    """
    from bt_mission.commands.graph.form_fields import example, lines_of

    if not part.shape.fields:
        return
    lines = (
        f"no goal was given; the fields of a goal of {name}:",
        *columns((f"  {line.name}", line.kind, line.note) for line in lines_of(part)),
        f"give the fields needed, such as: bt-mission actions send {name} {quote(example(part))}",
        "'{}' sends a goal with all defaults, --form asks for each field",
    )
    raise BtMissionError("\n".join(lines), code="BT-1102")


def _require_terminal() -> None:
    """Refuse a form where there is no terminal.

    Raises:
        BtMissionError: With what to do instead.
    """
    if not (sys.stdin.isatty() and sys.stdout.isatty()) or os.environ.get("TERM") == "dumb":
        raise BtMissionError(
            "--form needs a terminal; give the goal as YAML instead", code="BT-1102"
        )


def cancel(options: argparse.Namespace) -> int:
    """Cancel goals and wait for their end."""
    from bt_mission.commands.graph.action_goals import cancel_goals

    with graph_command.joined(options) as session:
        name, _ = graph_command.named("action", session, options)
        done = cancel_goals(session, name, options.goal, print, server_s=options.wait)
        return SUCCESS if done.all_ended else LOST if done.all_taken else REJECTED


def watch(options: argparse.Namespace) -> int:
    """Show the goals of an action until Ctrl-C."""
    from bt_mission.commands.graph.action_goals import GoalWatch
    from bt_mission.commands.graph.goal_views import goal_view_for
    from bt_mission.commands.graph.interface_description import describe_interface

    with graph_command.joined(options) as session:
        name, type_name = graph_command.named("action", session, options)
        about = describe_interface(type_name)
        goals = GoalWatch(session, name, type_name)
        print(f"watching {name}; Ctrl-C ends it", file=sys.stderr, flush=True)
        with closing(goal_view_for(sys.stdout, about, json=options.json, plain=False)) as view:
            while not session.interrupts.count:
                session.step()
                for event in goals.take():
                    view.show(event)
    return INTERRUPTED


def _code(how: GoalOutcome) -> int:
    from bt_mission.commands.graph.goal_events import GoalOutcome

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


def _command(
    function: Callable[[argparse.Namespace], int],
    wanted: str,
    help: str,  # noqa: A002 - as argparse calls it
    description: str = "",
    *options: Option,
    epilog: str = "",
) -> Command:
    """Return a command about an action, whose words come before the options of the graph.

    Args:
        wanted: What is looked for in the graph.
    """
    words = [option for option in options if not option.flags]
    return Command(
        function,
        description,
        (
            graph_command.name_option("action", "/turn"),
            *words,
            graph_command.type_option("the action's"),
            *graph_command.graph_options(wanted),
            *(option for option in options if option.flags),
        ),
        epilog,
        help,
        leaves_at_once=True,
    )


COMMANDS = {
    "actions": graph_command.graph_command(
        "actions",
        {
            "list": graph_command.list_command(
                "action", "list the actions of the graph and their servers"
            ),
            "info": _command(
                info,
                "the action",
                "show the nodes of an action and the fields of its messages, with units",
                "",
                graph_command.json_option("one object"),
            ),
            "send": _command(
                send,
                "a server",
                "send a goal and wait until it ends",
                "Sends a goal and shows its feedback until it ends. Ctrl-C cancels the goal and "
                "waits up to 10 s until it ends; a second Ctrl-C exits at once and prints the id "
                "of the goal.",
                Option("goal", GOAL, nargs="?", default=""),
                Option("--timeout SECONDS", "cancel the goal after this time", seconds),
                PLAIN,
                graph_command.json_option("one object per line for each event"),
                Option(
                    "--form",
                    "fill in the goal field by field, on a terminal",
                    excludes=each("json", "timeout"),
                    check=_require_terminal,
                ),
                epilog=EPILOG.partition("\n\n")[2],
            ),
            "cancel": _command(
                cancel,
                "a server",
                "cancel goals of any client, and wait until they end",
                "Cancels one goal or all goals of an action, of any client, and waits up to 10 s "
                "until they end.",
                Option(
                    "goal",
                    "id of the goal, or its first digits (default: all goals)",
                    nargs="?",
                    default="",
                ),
            ),
            "watch": _command(
                watch,
                "the action",
                "show the goals of an action and their feedback",
                "Shows each goal of an action, its feedback and its end, until Ctrl-C.",
                graph_command.json_option("one object per line"),
            ),
        },
        EPILOG,
    )
}
