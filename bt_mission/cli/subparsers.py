"""The argument that names a command: each has a parser, made from its module when it is called.

The rows of the commands are in :mod:`bt_mission.base.commands`.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

from bt_mission.base.commands import ROWS, CommandRow, all_rows, row_of
from bt_mission.base.errors import BtMissionError

if TYPE_CHECKING:
    from bt_mission.cli.parser import Command


def declared(row: CommandRow) -> Command:
    """Return the declaration of a command.

    Raises:
        BtMissionError: Its folder is absent, or a package that it imports is.
    """
    if not row.is_there:
        folders = " and ".join(row.absent)
        raise BtMissionError(
            f"'{row.name}' is not part of this installation: {folders} is absent", code="BT-905"
        )
    try:
        command: Command = import_module(row.declared_in).COMMANDS[row.name]
    except ModuleNotFoundError as error:
        raise lacks(row, error) from error
    return command


def lacks(row: CommandRow, error: ModuleNotFoundError) -> BtMissionError:
    """Return the error about a package that a command lacks, with what installs it."""
    way = f": pip install 'bt-mission[{row.extra}]'" if row.extra else ""
    return BtMissionError(f"'{row.name}' needs the package {error.name}{way}", code="BT-905")


def called(words: Sequence[str]) -> CommandRow | None:
    """Return the row of the command that words of the command line begin with."""
    try:
        row = row_of(words[0]) if words else None
    except KeyError:
        return None
    return row if row and row.help else None


def passed_on(words: Sequence[str]) -> tuple[Sequence[str], Sequence[str]]:
    """Return the words for a command, and those after ``--`` for what it runs."""
    if "--" in words:
        row = called(words)
        if row and declared(row).passes_on:
            at = words.index("--")
            return words[:at], words[at + 1 :]
    return words, ()


class Commands(argparse._SubParsersAction):  # type: ignore[type-arg]  # noqa: SLF001 - has no public name
    """The word that names a command. Lists all commands, and loads the one that is called."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._is_listed = False
        self._unloaded = {row.name: row for row in ROWS if row.help}
        for name in self._unloaded:
            self._name_parser_map[name] = None

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

    def know_all(self) -> None:
        """List the commands whose folders are there, and those of other packages."""
        if self._is_listed:
            return
        self._is_listed = True
        known = {name: row for name, row in all_rows().items() if row.help}
        for name in [name for name in self._unloaded if name not in known]:
            del self._unloaded[name], self._name_parser_map[name]
        for name, row in known.items():
            if name not in self._name_parser_map:
                self._unloaded[name], self._name_parser_map[name] = row, None
            self._choices_actions.append(self._ChoicesPseudoAction(name, (), row.help))

    def load(self, name: str) -> None:
        """Import the module of a command and make its parser."""
        row = self._unloaded.pop(name, None)
        if row is not None:
            del self._name_parser_map[name]
            declared(row).add_to(self, name, row.pages)


def commands_of(parser: argparse.ArgumentParser) -> Commands:
    """Return the argument of the command line's parser that names a command, with all of them."""
    # argparse has no public way to its arguments.
    (commands,) = (choice for choice in parser._actions if isinstance(choice, Commands))  # noqa: SLF001
    commands.know_all()
    return commands


def load_commands(parser: argparse.ArgumentParser) -> Commands:
    """Make the parsers of all commands of the command line's parser, in their order."""
    commands = commands_of(parser)
    for name in [name for name, row in all_rows().items() if row.help]:
        commands.load(name)
    return commands
