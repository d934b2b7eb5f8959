"""``bt-mission services``: what a graph can be asked, and asking it."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from bt_mission.base.errors import NotThereError
from bt_mission.cli.argument_types import seconds
from bt_mission.cli.exits import ABORTED, LOST, SUCCESS
from bt_mission.cli.parser import Command, Option
from bt_mission.commands.graph import graph_command

EPILOG = """\
examples:
  bt-mission services list
  bt-mission services call /stop
  bt-mission services call /motor_power 'data: false'

exit codes of call: 0 answered, 1 answered with success: false, 2 bad input, 5 no server,
6 no answer
"""


def call(options: argparse.Namespace) -> int:
    """Call a service and print its answer."""
    from bt_mission.commands.graph.interface_description import describe_interface
    from bt_mission.commands.graph.values import as_json, as_yaml, plain, read_fields
    from bt_mission.ros.clients import RosServiceClient
    from bt_mission.ros.graph_session import wait

    text = sys.stdin.read() if options.request == "-" else options.request
    with graph_command.joined(options) as session:
        name, type_name = graph_command.named("service", session, options)
        client = RosServiceClient(session.node, name, type_name)
        shape = describe_interface(type_name).part("request").shape
        request = client.prepare(read_fields(text, shape, "request"))
        if not wait(session, options.wait, client.is_ready):
            raise NotThereError(f"no server of {name} after {options.wait:g} s")
        answers: list[Any] = []
        forget = client.call(request, answers.append)
        if not wait(session, options.timeout, lambda: bool(answers)):
            forget()
            print(f"{name} did not answer within {options.timeout:g} s", file=sys.stderr)
            return LOST
    shown = plain(answers[0])
    print(as_json(shown) if options.json else as_yaml(shown), end="\n" if options.json else "")
    return ABORTED if getattr(answers[0], "success", True) is False else SUCCESS


COMMANDS = {
    "services": graph_command.graph_command(
        "services",
        {
            "list": graph_command.list_command("service", "list the services of the graph"),
            "call": Command(
                call,
                options=(
                    graph_command.name_option("service", "/stop"),
                    Option(
                        "request",
                        "fields of the request in YAML, such as 'data: true'; - reads standard "
                        "input",
                        nargs="?",
                        default="",
                    ),
                    graph_command.type_option(),
                    Option(
                        "--timeout SECONDS",
                        f"how long to wait for the answer (default: {graph_command.WAIT_S:g})",
                        seconds,
                        graph_command.WAIT_S,
                    ),
                    *graph_command.graph_options("a server"),
                    graph_command.json_option("one object"),
                ),
                help="call a service and print its answer",
                leaves_at_once=True,
            ),
        },
        EPILOG,
    )
}
