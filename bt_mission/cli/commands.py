"""The commands of the command line; the module of one is imported when it is called."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any, NamedTuple


class Command(NamedTuple):
    """A command."""

    adder: str
    """The function that adds its parser, below ``bt_mission.cli``: ``module:name``."""
    help: str
    """Its line in the list of commands."""


COMMANDS: Mapping[str, Command] = {
    "run": Command("run:add_parser", "carry a mission out"),
    "watch": Command(
        "watch:add_parser", "monitor a mission that runs elsewhere; pause, step or stop it"
    ),
    "check": Command("check:add_parser", "find every error of mission files"),
    "convert": Command(
        "convert:add_parser", "turn a mission from YAML into XML for Groot 2, and back"
    ),
    "new": Command(
        "new:add_parser", "make a project: a mission, a world, a test, and what an editor needs"
    ),
    "missions": Command(
        "listed_files:add_missions_parser", "list missions, shipped or your own; copy one to edit"
    ),
    "worlds": Command("listed_files:add_worlds_parser", "the same of worlds"),
    "robots": Command("listed_files:add_robots_parser", "the same of robots"),
    "tree": Command("tree:add_parser", "show a mission's tree as text, DOT, SVG or PNG"),
    "schema": Command(
        "check:add_schema_parser",
        "print the JSON Schema of mission, scenario or fleet files, for editors",
    ),
    "serve": Command(
        "serve:add_parser", "carry out missions that others send as goals of /execute_mission"
    ),
    "actions": Command("actions:add_parser", "list, send, cancel and watch goals by hand"),
    "topics": Command("topics:add_parser", "list topics, show their messages and rates"),
    "services": Command("services:add_parser", "list and call services"),
    "sim": Command("node_command:add_sim_parser", "run the simulated robot alone, as a ROS node"),
    "servers": Command(
        "node_command:add_servers_parser", "run the action servers alone, as a ROS node"
    ),
    "mapper": Command("node_command:add_mapper_parser", "map what the lidar sees, as a ROS node"),
    "arbiter": Command(
        "node_command:add_arbiter_parser",
        "let stop, joystick and missions drive one base, in this order",
    ),
    "replay": Command("replay:add_parser", "play a run again, from its recording or its trace"),
    "fork": Command(
        "fork:add_parser",
        "run a recorded run again up to an instant, and on from there with a change",
    ),
    "report": Command("report:add_parser", "make a page of a recorded run"),
    "verify": Command("verify:add_parser", "evaluate requirements over a recording"),
    "sweep": Command(
        "sweep:add_parser", "carry out a mission with many seeds, values, worlds and faults"
    ),
    "sweep-report": Command(
        "sweep_report:add_parser", "tables and a page of the results of a sweep"
    ),
    "falsify": Command("falsify:add_parser", "search for a scenario that breaks a mission"),
    "diff": Command(
        "diff:add_parser", "tell the first difference between two runs, by their traces"
    ),
    "doctor": Command("doctor:add_parser", "check this machine and say what to install"),
    "completion": Command(
        "completion:add_parser", "print a script that completes our commands in bash, zsh or fish"
    ),
}


class Commands(argparse._SubParsersAction):  # type: ignore[type-arg]  # noqa: SLF001 - has no public name
    """The word that names a command. Lists all commands, and loads the one that is called."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._unloaded = dict(COMMANDS)
        for name, command in COMMANDS.items():
            self._name_parser_map[name] = None
            self._choices_actions.append(self._ChoicesPseudoAction(name, (), command.help))

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        """Hand the remaining words to the command; `root` of the namespace is then the parser."""
        assert values is not None
        self.load(values[0])
        namespace.root = parser
        super().__call__(parser, namespace, values, option_string)

    def load(self, name: str) -> None:
        """Import the module of a command and make its parser."""
        if name not in self._unloaded:
            return
        module, _, adder = self._unloaded.pop(name).adder.partition(":")
        del self._name_parser_map[name]
        getattr(import_module(f"bt_mission.cli.{module}"), adder)(self)

    def load_all(self) -> None:
        """Make the parsers of all commands, in their order."""
        for name in COMMANDS:
            self.load(name)


def load_commands(parser: argparse.ArgumentParser) -> None:
    """Make the parsers of all commands of the command line's parser, for who looks at them."""
    for action in parser._actions:  # noqa: SLF001 - argparse has no public way to its arguments
        if isinstance(action, Commands):
            action.load_all()
