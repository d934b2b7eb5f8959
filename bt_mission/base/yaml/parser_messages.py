"""Errors of the YAML parser in plain words, at the place that helps most."""

from __future__ import annotations

import re
from typing import Any

_UNCLOSED = {
    "while parsing a flow sequence": "this '[' has no closing ']'",
    "while parsing a flow mapping": "this '{' has no closing '}'",
    "while scanning a quoted scalar": "this quote is never closed",
}
_UNCLOSED_PROBLEMS = frozenset(
    (
        "did not find expected ',' or ']'",
        "did not find expected ',' or '}'",
        "found unexpected end of stream",
    )
)
_SECOND_COLON = re.compile(
    r"""[ ]*(?:-[ ]+)*(?P<key>[^\s'"{\[:#][^:#]*?)[ ]*:[ ]+
    (?P<text>[^\s'"{\[|>&*!][^\#]*?:(?:[ ][^\#]*?)?)(?:[ ]+\#.*|[ ]*)""",
    re.VERBOSE,
)
MAX_DEPTH = 200
"""Levels of nesting, aliases followed. A tree node takes two to three levels."""

TOO_DEEP = f"nested too deeply; the limit is {MAX_DEPTH} levels"

_TAB = "a tab in the indentation; YAML requires spaces"
_PROBLEMS = {
    "mapping values are not allowed in this context": (
        "unexpected ':'; check the indentation, or quote the text that contains it"
    ),
    "did not find expected node content": "expected a value here",
    "did not find expected <document start>": "expected 'key: value', got text",
    "could not find expected ':'": "expected ':' after a key",
    "found unknown escape character": (
        "an unknown escape in a double-quoted text; write '\\\\' for a backslash"
    ),
    "found undefined tag handle": "a tag is not allowed",
    # libyaml 0.2.6 has its own limit: 1,000 levels, counted before it yields an event.
    "exceeded maximum nesting depth": TOO_DEEP,
}

_CODES = {TOO_DEEP: "BT-103", _TAB: "BT-104", _PROBLEMS["found undefined tag handle"]: "BT-108"}


def translate(error: Any, lines: tuple[str, ...]) -> tuple[str, str, tuple[int, int]]:
    """Return code, message, and line and column (from 1), for an error of the YAML parser."""
    message, at = _translated(error, lines)
    return _CODES.get(message, "BT-105"), message, at


def _translated(error: Any, lines: tuple[str, ...]) -> tuple[str, tuple[int, int]]:
    problem = getattr(error, "problem", None) or "the file cannot be parsed"
    context = getattr(error, "context", None) or ""
    start = _place(getattr(error, "context_mark", None), lines)
    at = _place(getattr(error, "problem_mark", None), lines) or start or (1, 1)
    if problem in _UNCLOSED_PROBLEMS and context in _UNCLOSED and start is not None:
        return _UNCLOSED[context], start
    if problem == "found character that cannot start any token":
        char = lines[at[0] - 1][at[1] - 1 : at[1]]
        if char == "\t":
            return _TAB, at
        return f"a value cannot start with '{char}'; put it in quotes", at
    if problem == "mapping values are not allowed in this context" and (
        unquoted := _SECOND_COLON.fullmatch(lines[at[0] - 1])
    ):
        text = unquoted["text"].replace("'", "''")
        return f"a second ':' in a line; quote the text: {unquoted['key']}: '{text}'", at
    if problem == "did not find expected '-' indicator" and start is not None:
        return f"expected '- ', an item of the list of line {start[0]}, or less indentation", at
    if problem == "did not find expected key" and start is not None:
        mapping = f"the mapping of line {start[0]}"
        return f"expected 'key: value' of {mapping}, or another indentation", at
    if "tab character" in problem:
        return _TAB, at
    return _PROBLEMS.get(problem, f"invalid YAML: {problem}"), at


def _place(mark: Any, lines: tuple[str, ...]) -> tuple[int, int] | None:
    """Return a mark as line and column; for the end of the file, the end of the last line."""
    if mark is None:
        return None
    line, column = mark.line + 1, mark.column + 1
    if line > len(lines) or (line == len(lines) and not lines[-1].strip()):
        last = max((i for i, text in enumerate(lines) if text.strip()), default=0)
        return last + 1, len(lines[last]) + 1
    return line, column
