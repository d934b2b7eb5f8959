"""Regular expressions of POSIX (extended), by the C library: what EntityFilters are written in.

Python's own have another syntax, and one that is badly meant can take them for ever; the C library
matches in a time that grows with the text alone, but for references back, which are refused.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterable

from bt_mission.core.errors import BtMissionError

MOST = 200
"""Characters of a pattern."""

_EXTENDED, _NO_PLACES = 1, 8
_ROOM = 256
"""Bytes for what a pattern is compiled to; glibc needs 64."""

_COSTLY = re.compile(r"\\[1-9]|\{.*\{")


class PatternError(BtMissionError):
    """A pattern that is none, or that is not taken."""


def matching(pattern: str, names: Iterable[str]) -> list[str]:
    """Return the names that a pattern is found in. Raises PatternError.

    >>> matching("^box_[0-9]+$", ["box_1", "my box_1"])
    ['box_1']
    """
    if len(pattern) > MOST or "\0" in pattern:
        raise PatternError(f"expected a pattern of at most {MOST} characters, none of them NUL")
    if _COSTLY.search(pattern):
        raise PatternError(
            "expected a pattern without references back (\\1), and with {} at most once"
        )
    library = ctypes.CDLL(None)
    compiled = ctypes.create_string_buffer(_ROOM)
    code = library.regcomp(compiled, pattern.encode(), _EXTENDED | _NO_PLACES)
    if code:
        text = ctypes.create_string_buffer(200)
        library.regerror(code, compiled, text, len(text))
        raise PatternError(f"not a regular expression (POSIX Extended): {text.value.decode()}")
    try:
        return [name for name in names if not library.regexec(compiled, name.encode(), 0, None, 0)]
    finally:
        library.regfree(compiled)
