"""The parser of the command line: wrapped help, and errors that name what was probably meant."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Sequence
from typing import Any, NoReturn

from bt_mission.core.diagnostics import did_you_mean
from bt_mission.core.text import escape_control


class HelpText(argparse.HelpFormatter):
    """Wraps each paragraph by itself; indented lines, such as examples, stay as they are."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        lines = text.splitlines()
        wrapped = (one if one.startswith(" ") else textwrap.fill(one, width) for one in lines)
        return textwrap.indent("\n".join(wrapped), indent)


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
        """Leave with an error, on one line after the usage."""
        super().error(escape_control(message))

    def refuse(self, words: Sequence[str]) -> None:
        """Leave with an error about words that mean nothing here."""
        options = [name for name in self._option_string_actions if name.startswith("--")]
        unknown = (word.partition("=")[0] for word in words if word.startswith("-"))
        hints = list(filter(None, (did_you_mean(word, options) for word in unknown)))
        self.error("; ".join([f"unrecognized arguments: {' '.join(words)}", *hints]))

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        choices = [str(one) for one in action.choices or ()]
        if choices and value not in choices:
            hint = did_you_mean(str(value), choices)
            raise argparse.ArgumentError(
                action,
                f"invalid choice: '{value}'"
                + (f"; {hint}" if hint else "")
                + f" (choose from {', '.join(choices)})",
            )
