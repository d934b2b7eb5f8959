"""The parser of the whole command line, and what becomes of errors."""

from __future__ import annotations

import argparse
import errno
import io
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from typing import Any

from bt_mission.base.commands import all_rows
from bt_mission.base.errors import BtMissionError, NotThereError
from bt_mission.base.interrupts import replaced_handlers
from bt_mission.cli.exits import BAD_INPUT, INTERRUPTED, MISSION_FAILED, NO_SERVER
from bt_mission.cli.inputs import settle_inputs
from bt_mission.cli.outputs import refuse_outputs
from bt_mission.cli.parser import Parser, refuse_contradictions
from bt_mission.cli.ros_arguments import split
from bt_mission.cli.subparsers import Commands, called, commands_of, lacks, passed_on
from bt_mission.views.terminal.streams import STANDARD_OUTPUT, escaped_output, unescaped

TRACEBACK = "BT_MISSION_TRACEBACK"
"""Set in the environment, it shows where an unexpected error came from."""

EXIT_CODES = """\
exit codes: 0 success, 1 mission failed, 2 bad input or an output that cannot be written, 130
interrupted; some commands have more, listed in their help
"""


class RootParser(Parser):
    """Parses the whole command line; its help lists the commands that are there."""

    def format_help(self) -> str:
        """Return the help, with the example of each command that has one."""
        commands_of(self)
        lines = [row.example for row in all_rows().values() if row.example]
        self.epilog = "\n".join(["examples:", *lines, "", EXIT_CODES])
        return super().format_help()

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if isinstance(action, Commands) and value not in (action.choices or ()):
            action.know_all()
        super()._check_value(action, value)


class Version(argparse.Action):
    """Prints the version. It is looked up only then: reading package data takes milliseconds."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        """Print and leave."""
        from importlib import metadata

        print(f"bt-mission {metadata.version('bt-mission')}")
        parser.exit()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; gives the exit code."""
    with escaped_output():
        return _run(arguments)


def _run(arguments: Sequence[str] | None) -> int:
    parser = make_parser()
    for stream in map(unescaped, (sys.stdout, sys.stderr)):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a sign that a terminal lacks ends no mission
    try:
        code = _run_command(parser, arguments)
    except NotThereError as error:
        print(error.headline, file=sys.stderr)
        return NO_SERVER
    except BtMissionError as error:
        print(error.headline, file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        _write_into_nothing()  # whoever read our output has left; there is nobody to tell
        return INTERRUPTED
    except Exception as error:  # a fault of ours or of the machine: a line instead of a traceback
        if os.environ.get(TRACEBACK):
            raise
        return _report_unexpected(error)
    return code


def _report_unexpected(error: Exception) -> int:
    """Print an unexpected error in a line; gives the exit code."""
    if isinstance(error, ImportError) and isinstance(error.__cause__, KeyboardInterrupt):
        return INTERRUPTED  # compiled code has hidden it
    if isinstance(error, OSError) and error.errno == errno.EIO:
        _write_into_nothing()  # the terminal was closed
        return INTERRUPTED
    if isinstance(error, OSError) and error.filename == STANDARD_OUTPUT:
        _write_into_nothing()
        print(f"cannot write {STANDARD_OUTPUT}: {error.strerror}", file=sys.stderr)
        return BAD_INPUT
    print(f"{type(error).__name__}: {error}", file=sys.stderr)
    print(
        f"`bt-mission doctor` checks this machine; {TRACEBACK}=1 shows the traceback",
        file=sys.stderr,
    )
    return MISSION_FAILED


def _run_command(parser: Parser, arguments: Sequence[str] | None) -> int:
    """Run a command, and flush its output here, where an error of that can still be handled."""
    try:
        options = _parsed(parser, arguments)
        refuse_contradictions(options)
        refuse_outputs(options)
        settle_inputs(options)
        with _leaving_at_once() if options.leaves_at_once else nullcontext():
            code = int(options.command(options))
    except ModuleNotFoundError as error:
        row = called(options.words)
        if row is None or not row.extra:
            raise
        raise lacks(row, error) from error
    except SystemExit:  # after a help text, for example
        sys.stdout.flush()
        raise
    sys.stdout.flush()
    return code


@contextmanager
def _leaving_at_once() -> Iterator[None]:
    """End the process on a signal: before a mission starts and after its end nothing is halted."""
    before = replaced_handlers(lambda *_: os._exit(INTERRUPTED))
    try:
        yield
    finally:
        for number, handler in before:
            signal.signal(number, handler)


def make_parser() -> RootParser:
    """The parser of all commands, each of which is loaded when it is called."""
    parser = RootParser(
        prog="bt-mission",
        description="Run missions written in YAML as behaviour trees over ROS 2 actions.",
    )
    parser.add_argument("--version", action=Version, nargs=0, help="print the version and exit")
    parser.add_subparsers(prog=parser.prog, metavar="command", action=Commands, parser_class=Parser)
    return parser


def _parsed(parser: Parser, arguments: Sequence[str] | None) -> Any:
    """Parse, with what argparse leaves behind when an optional word comes after an option.

    It takes such a word as absent once it has seen the words before the option.
    """
    own, after = passed_on(sys.argv[1:] if arguments is None else arguments)
    mine, for_ros = split(own)
    options, rest = parser.parse_known_args(mine)
    options.words, options.passed_on = mine, after
    if getattr(options, "takes_ros_args", False):
        options.ros_args = for_ros
    elif for_ros:
        options.parser.error(
            "--ros-args: this command takes no ROS arguments; give them to the nodes (bt-mission "
            "sim, servers, mapper, arbiter); the namespace of a mission is --namespace"
        )
    if not hasattr(options, "command"):
        options.parser.lead_on(rest)
    words = [option for option in options.parser.options if not option.flags][1:]
    late = words[-1] if words and words[-1].nargs == "?" else None
    is_word = len(rest) == 1 and (rest[0] == "-" or not rest[0].startswith("-"))
    if is_word and not late:
        _shift(options, rest)
    if late and is_word and not late.is_given(options):
        setattr(options, late.attribute, (late.type or str)(rest.pop()))
    if rest:
        options.parser.refuse(rest)
    return options


def _shift(options: Any, rest: list[str]) -> None:
    """Move a word that was taken for the second one to the first, where that is optional."""
    words = [option for option in options.parser.options if not option.flags]
    if len(words) < 2 or words[0].nargs != "?" or words[0].is_given(options):
        return
    first, second = words[:2]
    given = getattr(options, second.attribute)
    setattr(options, first.attribute, (first.type or str)(str(given)))
    setattr(options, second.attribute, (second.type or str)(rest.pop()))


def _write_into_nothing() -> None:
    """Have the interpreter flush what is left of our output without a complaint at its end."""
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, sys.stdout.fileno())
    os.close(nothing)
