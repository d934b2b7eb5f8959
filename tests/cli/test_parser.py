"""The parser: its help, its rules for options, and the ROS arguments that launch files append."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterator
from typing import get_args

import pytest

from bt_mission.base.files import FileKind
from bt_mission.cli.main import make_parser
from bt_mission.cli.parser import Option, Parser
from bt_mission.cli.ros_arguments import RosArgumentsError, checked, of_node, split
from bt_mission.cli.subparsers import load_commands
from bt_mission.commands.completion import KINDS
from tests.support.command_cases import cases
from tests.support.command_line import CommandLine

HELP = ["", "run", "watch", "serve", "replay", *cases("HELP")]


OF_A_GRAPH = ("executives", "namespaces")
"""Kinds of names that a command brings, and options of others have."""


@pytest.mark.parametrize("command", HELP)
def test_help_is_wrapped(cli: CommandLine, monkeypatch: pytest.MonkeyPatch, command: str) -> None:
    """Only a command of an example, which is to be copied, may be longer than the line."""
    monkeypatch.setenv("COLUMNS", "80")
    long = [line for line in cli.lines(f"{command} --help") if len(line) > 80]
    assert [line for line in long if not line.startswith("  bt-mission ") or "   " in line] == []


def test_the_main_command_teaches_by_examples(cli: CommandLine) -> None:
    """The parser accepts each of them."""
    lines = cli("run --help").partition("\nexamples:\n")[2].splitlines()
    examples = [line.split("  ")[1] for line in lines if line.startswith("  bt-mission run ")]
    assert len(examples) >= 5
    for example in examples:
        assert make_parser().parse_args(shlex.split(example)[1:]).file.name


def test_a_paragraph_of_help_is_filled_as_a_whole(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However its lines are broken in the source."""
    monkeypatch.setenv("COLUMNS", "80")
    assert cli.lines("--help")[-2:] == [
        "exit codes: 0 success, 1 mission failed, 2 bad input or an output that cannot",
        "be written, 130 interrupted; some commands have more, listed in their help",
    ]


@pytest.mark.parametrize(("command", "shown"), [("", "  run "), *cases("WITHOUT_A_COMMAND")])
def test_without_a_command_the_commands_are_shown(
    cli: CommandLine, command: str, shown: str
) -> None:
    """As help, which is also an error."""
    assert shown in cli.refused(command)


@pytest.mark.parametrize(
    ("command", "lines"),
    [
        (
            "run",
            [
                "--port N with --web: listen on this port",
                "--resume with --journal: continue a mission where its",
                "--record-camera [{compressed,raw}] with --record or --report: also record",
                "(default: as fast as possible) (not with --attach)",
            ],
        ),
        ("watch", ["one JSON object per line (not with --once)"]),
        ("check", ["--network discover processes"]),
    ],
)
def test_help_names_what_an_option_needs_and_excludes(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch, command: str, lines: list[str]
) -> None:
    """Of the options that the command has."""
    monkeypatch.setenv("COLUMNS", "200")
    help_ = " ".join(cli(f"{command} --help").split())
    assert [line for line in lines if line not in help_] == []


def _declared(action: argparse.Action) -> Iterator[tuple[Parser, Option]]:
    """Yield all options of the commands below an argument, each with the parser that has it."""
    if isinstance(action.choices, dict):
        for parser in action.choices.values():
            yield from ((parser, option) for option in parser.options)
            for inner in parser._actions:
                yield from _declared(inner)


def test_rules_name_options_kinds_and_names_that_exist() -> None:
    """A rule with a wrong name would never apply; nor would one whose option no command has."""
    declared = list(_declared(load_commands(make_parser())))
    assert len(declared) > 150
    known = {option.attribute for _, option in declared}
    kinds = {*get_args(FileKind), "trace"}
    for parser, option in declared:
        assert {*option.needs, *option.excludes} <= known, option.form
        assert {*option.not_for} <= kinds, option.form
        assert option.completes in {"", "folders", *KINDS, *OF_A_GRAPH}, option.form
        names = {each.attribute for each in parser.options}
        assert not option.needs or names & {*option.needs}, (parser.prog, option.form)


def test_ros_arguments_are_taken_out_of_the_command_line() -> None:
    """Wherever they stand, up to a double dash."""
    line = shlex.split("sim --ros-args -p speed:=2.0 -- --seed 3 --ros-args -r a:=b")
    assert split(line) == (["sim", "--seed", "3"], ["-p", "speed:=2.0", "-r", "a:=b"])


@pytest.mark.parametrize("command", ["sim", "servers", "mapper", "arbiter", "serve"])
def test_commands_that_run_a_node_take_ros_arguments(command: str) -> None:
    """Their help says so."""
    assert make_parser().parse_args([command]).takes_ros_args


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [(["-p"], "trailing -p"), (["-r", "x"], "'-r x'"), (["--bogus"], "--bogus")],
)
def test_ros_arguments_that_ros_cannot_read_are_refused(wrong: list[str], reason: str) -> None:
    """With its own reason, without a place in its sources."""
    with pytest.raises(RosArgumentsError) as caught:
        checked(wrong)
    assert reason in str(caught.value)
    assert "/src/" not in str(caught.value)


def test_ros_arguments_that_ros_can_read_stay_as_they_are() -> None:
    """A new name is for the node that the command is about; a namespace is for all."""
    given = ["-r", "scan:=laser", "-p", "a:=1", "--log-level", "info"]
    assert checked(given) == tuple(given)
    given = ["-r", "__node:=executive", "-r", "__ns:=/r1"]
    assert of_node(given, "bt_mission") == ("-r", "bt_mission:__node:=executive", "-r", "__ns:=/r1")
