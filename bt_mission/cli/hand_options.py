"""What the commands that work on a graph by hand have in common."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from bt_mission.core.dds.middleware import prepare_middleware

if TYPE_CHECKING:
    from bt_mission.graph_tools.graph_session import JoinedGraphSession

WAIT_S = 5.0


def add_graph_options(parser: argparse.ArgumentParser, what: str) -> None:
    """Where to look, and for how long."""
    parser.add_argument("--namespace", default="", help="of names without a leading slash")
    parser.add_argument(
        "--wait",
        type=seconds,
        default=WAIT_S,
        metavar="SECONDS",
        help=f"how long to look for {what} (default: {WAIT_S:g})",
    )


def add_json_option(parser: argparse.ArgumentParser, what: str) -> None:
    """For programs."""
    parser.add_argument("--json", action="store_true", help=f"for programs: {what}")


def subcommands(commands: Any, name: str, words: str, epilog: str) -> Any:
    """A command that has commands of its own."""
    parser = commands.add_parser(
        name,
        help=words,
        description=f"{words[0].upper()}{words[1:]}. Works with any ROS 2 graph, and with every "
        "type that is installed.",
        epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    return parser.add_subparsers(metavar="what", required=True)


def seconds(text: str) -> float:
    """A time from the command line, s."""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"expected seconds, 0 or more, got '{text}'")
    return value


def count(text: str) -> int:
    """A number of things from the command line, 1 or more."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number from 1, got '{text}'")
    return int(text)


@contextmanager
def joined(options: argparse.Namespace) -> Iterator[JoinedGraphSession]:
    """A hand in the graph."""
    from bt_mission.cli.run import leaving_at_once

    with leaving_at_once():
        prepare_middleware()
        from bt_mission.graph_tools.graph_session import JoinedGraphSession

        with JoinedGraphSession(options.namespace) as hand:
            yield hand


def print_found(
    options: argparse.Namespace, what: str, rows: Iterable[Sequence[str]], objects: object
) -> None:
    """Print what was found in the graph: a table, or a list of objects; or that it is none."""
    from bt_mission.graph_tools.listing import columns
    from bt_mission.graph_tools.values import as_json

    lines = [as_json(objects)] if options.json else columns(rows)
    if not lines:
        print(f"no {what} in the graph (looked for {options.wait:g} s)", file=sys.stderr)
    for line in lines:
        print(line)
