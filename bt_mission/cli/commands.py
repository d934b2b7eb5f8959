"""The commands of the command line; the module of one is imported when it is called."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

COMMANDS: Mapping[str, str] = {
    "run": "run a mission",
    "play": "run programs of rclpy with the simulated robot, without a mission",
    "watch": "monitor a running mission; pause, step or stop it",
    "revise": "continue a running mission with another version of its file",
    "edit": "write, check, draw and run missions in a browser",
    "check": "check mission files and report every error",
    "convert": "convert missions between YAML and the XML of Groot 2",
    "new": "create a project: a mission, a world, a test, and editor settings",
    "missions": "list shipped and local missions; copy one to edit",
    "worlds": "list worlds; copy one to edit",
    "robots": "list robots; copy one to edit",
    "tree": "draw the tree of a mission as text, DOT, SVG or PNG",
    "schema": "print the JSON Schema of a kind of file, for editors",
    "serve": "run missions that other nodes send as goals of /execute_mission",
    "mcp": "let agents propose missions, collect evidence, and drive with a permit",
    "approve": "permit one drive of a mission that an agent has proposed",
    "actions": "list actions; send, cancel and watch goals",
    "topics": "list topics; show their messages and rates",
    "services": "list and call services",
    "sim": "run the simulated robot alone, as a ROS node",
    "servers": "run the action servers alone, as a ROS node",
    "mapper": "run the mapper alone, as a ROS node",
    "arbiter": "give stop, joystick and missions access to one base, in this order of priority",
    "replay": "play back a recording or a trace",
    "fork": "repeat a recorded run up to an instant, then continue with a change",
    "report": "generate an HTML report of a recorded run",
    "verify": "evaluate requirements on a recording",
    "sweep": "run a mission with many seeds, inputs, worlds and faults",
    "sweep-report": "show the results of a sweep as tables and an HTML page",
    "falsify": "search for a scenario that breaks a mission",
    "reproduce": "turn a recording into a scenario that repeats its run in the simulation",
    "prove": "check a mission against every answer that its servers can give",
    "diff": "show the first difference between the traces of two runs",
    "explain": "explain an error code, such as BT-203, with an example",
    "doctor": "check this machine and list what to install",
    "docs": "show or search the documentation",
    "completion": "print the completion script for bash, zsh or fish",
}
"""Their names, with the line of each in the list of commands."""

PAGES: Mapping[str, Sequence[str]] = {
    "run": ("first-mission", "scenarios", "recording"),
    "play": ("test-the-server-you-have", "own-nodes"),
    "watch": ("terminal", "watch-in-a-browser"),
    "revise": ("change-while-it-drives",),
    "edit": ("edit-in-a-browser", "mission-language"),
    "check": ("mission-language", "nodes", "errors"),
    "convert": ("groot",),
    "new": ("own-project", "first-mission"),
    "missions": ("own-project", "mission-language"),
    "worlds": ("own-project", "files"),
    "robots": ("own-project", "files"),
    "tree": ("command-line-tools",),
    "schema": ("own-project", "files"),
    "serve": ("serving", "deploy"),
    "mcp": ("let-an-agent-propose-missions", "agents"),
    "approve": ("let-an-agent-propose-missions", "agents"),
    "actions": ("command-line-tools", "actions"),
    "topics": ("command-line-tools",),
    "services": ("command-line-tools",),
    "sim": ("simulator", "files"),
    "servers": ("actions", "real-robot", "safety"),
    "mapper": ("exploration", "real-robot"),
    "arbiter": ("real-robot", "safety"),
    "replay": ("terminal", "recording"),
    "fork": ("fork",),
    "report": ("recording",),
    "verify": ("how-to/requirements", "reference/requirements"),
    "sweep": ("cluster", "sweeps", "ranges"),
    "sweep-report": ("sweeps", "cluster"),
    "falsify": ("break-your-mission", "search", "ranges"),
    "reproduce": ("from-a-recording-to-a-test", "recording"),
    "prove": ("prove-a-mission",),
    "diff": ("trace",),
    "explain": ("errors", "troubleshooting"),
    "doctor": ("install", "troubleshooting"),
    "completion": ("command-line-tools",),
}
"""The pages of the documentation about each command, which its help names."""

_MODULES = {
    **dict.fromkeys(("missions", "worlds", "robots"), "listed_files"),
    **dict.fromkeys(("sim", "servers", "mapper", "arbiter"), "node_command"),
    **{name: f"graph.{name}" for name in ("actions", "topics", "services")},
    **{
        name: f"{name}.command"
        for name in (
            "convert",
            "docs",
            "edit",
            "falsify",
            "fork",
            "new",
            "prove",
            "reproduce",
            "sweep",
        )
    },
    "mcp": "agents.mcp_command",
    "approve": "agents.approve_command",
    "schema": "check",
    "sweep-report": "sweep.report_command",
}


def module_of(name: str) -> str:
    """Return the module whose ``COMMANDS`` have the declaration of a command."""
    return f"bt_mission.commands.{_MODULES.get(name, name)}"


def passed_on(words: Sequence[str]) -> tuple[Sequence[str], Sequence[str]]:
    """Return the words for a command, and those after ``--`` for what it runs."""
    if "--" in words and words[0] in COMMANDS:
        command = import_module(module_of(words[0])).COMMANDS[words[0]]
        if command.passes_on:
            at = words.index("--")
            return words[:at], words[at + 1 :]
    return words, ()


class Commands(argparse._SubParsersAction):  # type: ignore[type-arg]  # noqa: SLF001 - has no public name
    """The word that names a command. Lists all commands, and loads the one that is called."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._unloaded = dict(COMMANDS)
        for name, words in COMMANDS.items():
            self._name_parser_map[name] = None
            self._choices_actions.append(self._ChoicesPseudoAction(name, (), words))

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
        if self._unloaded.pop(name, None) is not None:
            del self._name_parser_map[name]
            import_module(module_of(name)).COMMANDS[name].add_to(self, name, PAGES.get(name, ()))


def load_commands(parser: argparse.ArgumentParser) -> Commands:
    """Make the parsers of all commands of the command line's parser, in their order."""
    # argparse has no public way to its arguments.
    (commands,) = (choice for choice in parser._actions if isinstance(choice, Commands))  # noqa: SLF001
    for name in COMMANDS:
        commands.load(name)
    return commands
