"""The parser of the command line: wrapped help, and errors that name what was probably meant."""

from __future__ import annotations

import argparse
import re
import sys
import textwrap
from collections.abc import Sequence
from itertools import groupby
from typing import Any, NoReturn

from bt_mission.cli.exits import BAD_INPUT
from bt_mission.core.text import escape_control

_REMARK = re.compile(r"(?<=\S) {2,}(?=\S)")
"""The blanks between an example and what is said of it."""


class HelpText(argparse.HelpFormatter):
    """Wraps each paragraph by itself; indented lines, such as examples, stay as they are.

    Where a line of such a block is too long, what is said of each line stands below it.
    """

    def _fill_text(self, text: str, width: int, indent: str) -> str:
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
        said = escape_control(message)
        self.exit(BAD_INPUT, f"{self.prog}: error: {said}; see '{self.prog} --help'\n")

    @property
    def arguments(self) -> Sequence[argparse.Action]:
        """All options and words that it knows."""
        return self._actions

    def refuse(self, words: Sequence[str]) -> NoReturn:
        """Leave with an error about words that mean nothing here."""
        from bt_mission.core.diagnostics import did_you_mean

        options = [name for name in self._option_string_actions if name.startswith("--")]
        unknown = (word.partition("=")[0] for word in words if word.startswith("-"))
        hints = list(filter(None, (did_you_mean(word, options) for word in unknown)))
        self.error("; ".join([f"unrecognized arguments: {' '.join(words)}", *hints]))

    def lead_on(self, words: Sequence[str]) -> NoReturn:
        """Leave where no command is given: show which there are, or refuse the words."""
        if words:
            self.refuse(words)
        self.print_help(sys.stderr)
        self.exit(BAD_INPUT)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        choices = [str(one) for one in action.choices or ()]
        if choices and value not in choices:
            from bt_mission.core.diagnostics import did_you_mean

            hint = did_you_mean(str(value), choices)
            raise argparse.ArgumentError(
                action,
                f"invalid choice: '{value}'"
                + (f"; {hint}" if hint else "")
                + f" (choose from {', '.join(choices)})",
            )
