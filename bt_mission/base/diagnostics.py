"""Diagnostics: what is wrong with an input, where, and what to do."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, Literal

from bt_mission.base.errors import BtMissionError
from bt_mission.base.text import escape_control

Severity = Literal["error", "warning"]

SHOWN_WIDTH = 100
"""Columns of a source line that a diagnostic shows; longer lines are cut around the caret."""

SHOWN_DIAGNOSTICS = 50
"""Diagnostics that an InputError prints; the rest is counted."""


MOST_DIAGNOSTICS = 200
"""The search for mistakes ends after this number of them."""

CUT = "a comma ends a text inside {} or []: put the text in quotes"
"""The hint at a text that ends where a parenthesis in it is still open."""

_REST = re.compile(r",[^)\]}]*\)?[^,\]}]*")
"""What a comma cuts off such a text: up to its closing parenthesis, and the end of that value."""

LIKENED_NAMES = 500
"""Names that a mistaken one is compared with; comparing takes some 20 us each."""


@dataclass(frozen=True)
class Diagnostic:
    """One mistake in an input, and its place.

    `code` is the kind of mistake, a row of `error_catalogue.toml`. `line` and `column` count from
    1; line 0 stands for the whole file. `source` is the line itself. `hint` says what to write
    instead.
    """

    code: str
    message: str
    file: str
    line: int = 0
    column: int = 0
    source: str = ""
    hint: str | None = None
    severity: Severity = "error"

    def __str__(self) -> str:
        if not self.line or not self.source.strip():
            return self.headline
        shown, caret = _excerpt(self.source, self.column)
        return f"{self.headline}\n    {shown}\n    {caret}^"

    def as_dict(self) -> dict[str, Any]:
        """Return the fields for JSON, without the line of the input."""
        keys = ("file", "line", "column", "severity", "code", "message", "hint")
        return {key: getattr(self, key) for key in keys}

    @property
    def headline(self) -> str:
        """Place, message, hint and code, without the line of the input itself."""
        place = f"{self.file}:{self.line}:{self.column}" if self.line else self.file
        hint = f"; {self.hint}" if self.hint else ""
        return escape_control(f"{place}: {self.severity}: {self.message}{hint} [{self.code}]")


def diagnostic_at(
    code: str,
    place: tuple[int, int],
    file: str,
    lines: Sequence[str],
    message: str,
    hint: str | None = None,
    severity: Severity = "error",
) -> Diagnostic:
    """Return a diagnostic at a line and column (from 1) of a file with these lines."""
    line, column = place
    source = lines[line - 1] if 0 < line <= len(lines) else ""
    return Diagnostic(code, message, file, line, column, source, hint, severity)


class InputError(BtMissionError):
    """An input that cannot be used, with all diagnostics of it."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__(self.diagnostics)

    def __str__(self) -> str:
        return "\n".join(self._shown(str))

    @property
    def on_one_line(self) -> str:
        """All diagnostics in one line, without the lines of the input."""
        return " | ".join(self._shown(lambda each: each.headline))

    def _shown(self, written: Callable[[Diagnostic], str]) -> list[str]:
        shown = [written(each) for each in self.diagnostics[:SHOWN_DIAGNOSTICS]]
        more = len(self.diagnostics) - SHOWN_DIAGNOSTICS
        return [*shown, f"... and {more} more"] if more > 0 else shown


def in_order(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Return diagnostics in the order of their file, each once; one file after another.

    Where a comma has cut a text off, those of its rest are left out.
    """
    given = dict.fromkeys(diagnostics)
    rests = [(each, _end_of_rest(each)) for each in given if each.hint == CUT]
    kept = [
        each
        for each in given
        if not any(
            (each.file, each.line) == (cut.file, cut.line) and cut.column < each.column <= end
            for cut, end in rests
        )
    ]
    files = list(dict.fromkeys(each.file for each in kept))
    return tuple(sorted(kept, key=lambda each: (files.index(each.file), each.line, each.column)))


def _end_of_rest(cut: Diagnostic) -> int:
    """Return the column behind what a comma has cut off a text; 0 where no comma follows it."""
    rest = _REST.match(cut.source, max(cut.column - 1, 0))
    return rest.end() + 1 if rest else 0


def did_you_mean(name: str, valid: Iterable[str]) -> str | None:
    """Return "did you mean 'x'?" for the nearest name, or one with it as a word; None without."""
    import difflib  # noqa: PLC0415 - for errors alone

    known = list(islice(valid, LIKENED_NAMES))
    near = difflib.get_close_matches(name[:100], known, n=1, cutoff=0.6)
    near = near or [other for other in known if name in re.split(r"[_./]", other)]
    return f"did you mean '{escape_control(near[0])}'?" if near else None


def listed(names: Iterable[str], most: int = 40) -> str:
    """Return names as "a, b, c", cut after `most`; "none" for an empty list."""
    known = list(names)
    if not known:
        return "none"
    more = f", and {len(known) - most} more" if len(known) > most else ""
    return escape_control(", ".join(known[:most])) + more


def describe(value: object) -> str:
    """Describe a value that was read from YAML: "text 'fast'", "a list of 3"."""
    match value:
        case None:
            return "nothing"
        case bool():
            return "true" if value else "false"
        case int() | float():
            return f"the number {value}"
        case str():
            return f"string {quoted(value)}"
        case list() | tuple():
            return f"a list of {len(value)}" if value else "an empty list"
        case dict():
            keys = listed(map(str, value), 6)
            return f"a mapping with {keys}" if value else "an empty mapping"
        case _:
            return f"a value of type {type(value).__name__}"


def quoted(text: str) -> str:
    """Return the text in single quotes on one line, cut after 60 characters."""
    cut = text if len(text) <= 60 else text[:57] + "..."
    return f"'{escape_control(cut)}'"


def _excerpt(source: str, column: int) -> tuple[str, str]:
    """Return the part of a line around a column, and the blanks that put a caret under it."""
    at = max(column - 1, 0)
    start = 0
    if len(source) > SHOWN_WIDTH:
        start = max(0, min(at - SHOWN_WIDTH // 2, len(source) - SHOWN_WIDTH))
    shown = escape_control(source[start : start + SHOWN_WIDTH].replace("\t", " "))
    before = escape_control(source[start:at].replace("\t", " "))
    blanks = sum(2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in before)
    lead, tail = ("... " if start else "", " ..." if start + SHOWN_WIDTH < len(source) else "")
    return (lead + shown.rstrip() + tail), " " * (blanks + len(lead))
