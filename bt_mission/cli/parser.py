"""What the command line is made of: commands, options with their rules, and the parser of them.

A command and an option are declared once, as data. The parser, the help text, the refusal of
options that contradict each other and the completion of shells all follow from the declaration.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from pathlib import Path
from typing import Any, NoReturn

from bt_mission.base.commands import page
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import SUFFIXES
from bt_mission.base.text import escape_control
from bt_mission.cli.exits import BAD_INPUT

_REMARK = re.compile(r"(?<=\S) {2,}(?=\S)")
"""The blanks between an example and its remark."""


def each(*names: str, why: str = "") -> Mapping[str, str]:
    """Return a rule: the names of other options, or of kinds of file, each with the reason."""
    return dict.fromkeys(names, why)


@dataclass(frozen=True)
class Option:
    """An option or a word of a command, as it is declared.

    Attributes:
        form: As it is written: ``--web``, ``-o --output FILE``; a word has no dash: ``file``. An
            option without a value is a flag.
        help: Its line in the help text, without what follows from the rules.
        type: Reads the value, or raises ``argparse.ArgumentTypeError``.
        default: The value where it is not given.
        choices: The valid values; empty where any will do.
        nargs: As ``argparse`` has it.
        const: The value where it is given without one (``nargs="?"``).
        repeats: It may be given several times; its value is a list.
        dest: The attribute of the parsed options, where it is not the form's.
        group: The heading below which the help text lists it.
        completes: The kind of names that a shell completes for it (``completion.KINDS``).
        needs: Other options, of which one has to be given with it, by their attributes.
        excludes: Other options that cannot be given with it.
        not_for: Kinds of file (``base.files.kind_of``) to which it does not apply.
        page: The page of the documentation about it.
        takes: Kinds of file that it names (``base.file_kinds.FORMATS``); none where any will do.
        check: Called where it is given, before the command starts; raises where the machine lacks
            what it needs.
    """

    form: str
    help: str
    type: Callable[[str], Any] | None = None
    default: Any = None
    choices: Sequence[str] = ()
    nargs: str | None = None
    const: Any = None
    repeats: bool = False
    dest: str = ""
    group: str = ""
    completes: str = ""
    needs: Mapping[str, str] = field(default_factory=dict)
    excludes: Mapping[str, str] = field(default_factory=dict)
    not_for: Mapping[str, str] = field(default_factory=dict)
    page: str = ""
    takes: Sequence[str] = ()
    check: Callable[[], None] | None = None

    def but(self, **changes: Any) -> Option:
        """Return the same option with something else in this command."""
        return replace(self, **changes)

    @property
    def flags(self) -> Sequence[str]:
        """Its names with their dashes; none of a word."""
        return [part for part in self.form.split() if part.startswith("-")]

    @property
    def name(self) -> str:
        """What messages call it: ``--web``, ``FILE``."""
        long = (flag for flag in self.flags if flag.startswith("--"))
        return next(long, self.form.split()[0].upper())

    @property
    def attribute(self) -> str:
        """Its attribute of the parsed options."""
        word = self.name if self.flags else self.form.split()[0]
        return self.dest or word.lstrip("-").replace("-", "_")

    @property
    def metavar(self) -> str:
        """The name of its value."""
        return " ".join(self.form.split()[len(self.flags) or 1 :])

    @property
    def is_flag(self) -> bool:
        """Is it without a value?"""
        return bool(self.flags) and not (self.metavar or self.choices or self.type)

    def is_given(self, options: argparse.Namespace) -> bool:
        """Has it another value than its default?"""
        unset: Any = [] if self.repeats else False if self.is_flag else None
        default = unset if self.default in (None, argparse.SUPPRESS) else self.default
        return bool(getattr(options, self.attribute, default) != default)

    def add_to(self, parser: Any, others: Mapping[str, Option]) -> None:
        """Add it to a parser, or to a group of options in one; `others` are its command's."""
        if self.is_flag:
            settings: dict[str, Any] = {"action": "store_true"}
        else:
            named = {
                "type": self.type,
                "choices": self.choices,
                "nargs": self.nargs,
                "const": self.const,
                "metavar": self.metavar,
            }
            settings = {name: value for name, value in named.items() if value}
            if self.repeats:
                settings |= {"action": "append", "default": []}
        if self.default is not None:
            settings["default"] = self.default
        if self.flags:
            settings["dest"] = self.attribute
        words = self.flags or [self.attribute]
        parser.add_argument(*words, help=self._described(others), **settings).option = self

    def _described(self, others: Mapping[str, Option]) -> str:
        """Its help, with the options that it needs and excludes, and its page."""
        if self.help == argparse.SUPPRESS:
            return self.help
        needed = " or ".join(others[name].name for name in self.needs if name in others)
        excluded = ", ".join(others[name].name for name in self.excludes if name in others)
        before = f"with {needed}: " if needed else ""
        after = f" (not with {excluded})" if excluded else ""
        read = f" ({page(self.page, '')})" if self.page else ""
        return f"{before}{self.help}{after}{read}"

    def refuse_contradictions(
        self, options: argparse.Namespace, others: Mapping[str, Option]
    ) -> None:
        """Refuse it where it would be ignored; names that the command does not have are skipped.

        Raises:
            BtMissionError: With the rule.
        """
        for name, why in self.excludes.items():
            if name in others and others[name].is_given(options):
                other = others[name].name
                if why:
                    raise BtMissionError(
                        f"{self.name} does not go with {other}: {why}", code="BT-1102"
                    )
                raise BtMissionError(f"{other} and {self.name}: choose one of them", code="BT-1102")
        needed = [others[name] for name in self.needs if name in others]
        if needed and not any(other.is_given(options) for other in needed):
            forms = " or ".join(f"{other.name} {other.metavar}".rstrip() for other in needed)
            reasons = "; ".join(dict.fromkeys(filter(None, self.needs.values())))
            raise BtMissionError(
                f"{self.name} goes with {forms}{reasons and f': {reasons}'}", code="BT-1102"
            )


@dataclass(frozen=True)
class Command:
    """A command, as it is declared.

    Attributes:
        function: Runs it with the parsed options and returns the exit code; None if only its
            subcommands run.
        description: What its help begins with.
        options: What it takes, in the order of its help.
        epilog: What its help ends with, before the pages.
        help: Its line in the help of the command above; those of the command line have theirs in
            their rows (:mod:`bt_mission.base.commands`).
        commands: Those below it.
        takes_ros_args: Hand ``--ros-args`` to its node.
        leaves_at_once: A signal ends the process while the command has nothing to halt.
        passes_on: The words after ``--`` are for what it runs.
    """

    function: Callable[[argparse.Namespace], int] | None
    description: str = ""
    options: Sequence[Option] = ()
    epilog: str = ""
    help: str = ""
    commands: Mapping[str, Command] = field(default_factory=dict)
    takes_ros_args: bool = False
    leaves_at_once: bool = False
    passes_on: bool = False

    def add_to(self, commands: Any, name: str, pages: Sequence[str]) -> None:
        """Add it, and those below it, to the commands of a parser; their help names the pages."""
        listed = {"help": self.help} if self.help else {}
        parser = commands.add_parser(
            name, description=self.description or None, epilog=self._ending(pages) or None, **listed
        )
        groups = {"": parser}
        declared = {declared_option.attribute: declared_option for declared_option in self.options}
        for option in self.options:
            if option.group not in groups:
                groups[option.group] = parser.add_argument_group(option.group)
            option.add_to(groups[option.group], declared)
        if self.function is not None:
            parser.set_defaults(command=self.function, leaves_at_once=self.leaves_at_once)
        parser.set_defaults(takes_ros_args=self.takes_ros_args)
        if self.commands:
            below = parser.add_subparsers(metavar="what")
            for word, command in self.commands.items():
                command.add_to(below, word, pages)

    def _ending(self, pages: Sequence[str]) -> str:
        """What its help ends with: its epilog, then how to open the pages."""
        if not pages:
            return self.epilog
        read = "\n".join(["read more:", *(f"  {page(name, '')}" for name in pages)])
        return f"{self.epilog.rstrip()}\n\n{read}" if self.epilog else read


def refuse_contradictions(options: argparse.Namespace) -> None:
    """Refuse options that would be ignored, and those for which the machine lacks something.

    Raises:
        BtMissionError: With the rule, or with what is missing.
    """
    declared = {
        declared_option.attribute: declared_option for declared_option in options.parser.options
    }
    given = [candidate for candidate in declared.values() if candidate.is_given(options)]
    for option in given:
        option.refuse_contradictions(options, declared)
    for option in given:
        if option.check is not None:
            option.check()


def refuse_for_kind(options: argparse.Namespace, kind: str) -> None:
    """Refuse options that do not apply to a kind of file.

    Raises:
        BtMissionError: With the reason.
    """
    for option in options.parser.options:
        if kind in option.not_for and option.is_given(options):
            raise BtMissionError(
                f"{option.name} does not apply to {kind} files: {option.not_for[kind]}",
                code="BT-1102",
            )


class HelpText(argparse.HelpFormatter):
    """Wraps each paragraph separately; indented lines, such as examples, are unchanged.

    Where a line of such a block is too long, the remark of each line is on a separate line.
    """

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        import textwrap

        filled: list[str] = []
        for is_block, group in groupby(text.splitlines(), key=lambda line: line[:1] in ("", " ")):
            lines = list(group)
            if not is_block:
                filled.append(textwrap.fill(" ".join(lines), width))
            elif max(map(len, lines)) > width:
                filled += [_REMARK.sub(r"\n      ", line) for line in lines]
            else:
                filled += lines
        return textwrap.indent("\n".join(filled), indent)


def _way_of_file(word: str) -> str | None:
    """Return the command for a file that was given in place of a command."""
    from bt_mission.base.file_kinds import format_of, way_with

    kind = format_of(Path(word))
    if kind is None and Path(word).suffix not in SUFFIXES:
        return None
    return f"it is a file: {way_with(kind or 'mission', word)}"


_FILE_OPTIONS = {"--mission", "--file", "--scenario", "--fleet", "--recording"}
"""Guessed options for what is a word."""


class Parser(argparse.ArgumentParser):
    """Parses the command line or, as those that it makes for them, the words of one command."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**{"formatter_class": HelpText, **options})

    def parse_known_args(  # type: ignore[override]  # its overloads are for namespaces of others
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse; `parser` of the namespace is then the one of the innermost command."""
        options, rest = super().parse_known_args(args, namespace)
        if not hasattr(options, "parser"):
            options.parser = self
        return options, rest

    def error(self, message: str) -> NoReturn:
        """Leave with an error on one line, which ends with where the help is."""
        text = escape_control(message)
        self.exit(BAD_INPUT, f"{self.prog}: error: {text}; see '{self.prog} --help' [BT-1101]\n")

    @property
    def options(self) -> Sequence[Option]:
        """All options and words that it knows, as they were declared."""
        return [action.option for action in self._actions if hasattr(action, "option")]

    def refuse(self, words: Sequence[str]) -> NoReturn:
        """Leave with an error about words that mean nothing here."""
        from bt_mission.base.diagnostics import did_you_mean

        options = [name for name in self._option_string_actions if name.startswith("--")]
        unknown = [word.partition("=")[0] for word in words if word.startswith("-")]
        hints = list(filter(None, (did_you_mean(word, options) for word in unknown)))
        first = next((option for option in self.options if not option.flags), None)
        if first is not None and set(unknown) & _FILE_OPTIONS:
            hints.append(f"give the file alone: {self.prog} FILE")
        self.error("; ".join([f"unrecognized arguments: {' '.join(words)}", *hints]))

    def lead_on(self, words: Sequence[str]) -> NoReturn:
        """Leave where no command is given: show which there are, or refuse the words."""
        if words:
            self.refuse(words)
        self.print_help(sys.stderr)
        self.exit(BAD_INPUT)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        choices = [str(choice) for choice in action.choices or ()]
        if choices and value not in choices:
            from bt_mission.base.diagnostics import did_you_mean

            hint = _way_of_file(str(value)) or did_you_mean(str(value), choices)
            raise argparse.ArgumentError(
                action,
                f"invalid choice: '{value}'"
                + (f"; {hint}" if hint else "")
                + f" (choose from {', '.join(choices)})",
            )
