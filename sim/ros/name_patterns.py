"""Regular expressions of POSIX (extended), by the C library, as EntityFilters have them.

Python's have another syntax, and a malicious one can take forever. The C library matches in a time
that grows only with the text, except for back references, which are refused. It compiles a
repetition to that many copies, each of which may have repetitions in turn: the total is computed
first, and bounded.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterable

from bt_mission.base.errors import BtMissionError

MOST = 200
"""Characters of a pattern."""

MOST_COPIES = 300
"""Characters of a pattern with its repetitions written out."""

_EXTENDED, _NO_PLACES = 1, 8
_ROOM = 256
"""Bytes of a compiled pattern; glibc needs 64."""

_REFERENCE = re.compile(r"\\[1-9]")
_REPETITION = re.compile(r"\+|\{([^}]*)")


class PatternError(BtMissionError):
    """A pattern that is invalid, or refused."""

    code = "BT-808"


def matching(pattern: str, names: Iterable[str]) -> list[str]:
    """Return the names that a pattern is found in. Raises PatternError.

    >>> matching("^box_[0-9]+$", ["box_1", "my box_1"])
    ['box_1']
    """
    if len(pattern) > MOST or "\0" in pattern:
        raise PatternError(f"expected a pattern of at most {MOST} characters, none of them NUL")
    if _REFERENCE.search(pattern):
        raise PatternError("expected a pattern without references back (\\1)")
    if _size_at_most(pattern) > MOST_COPIES:
        raise PatternError(
            "its repetitions are too many: + and {} of groups or of other repetitions multiply, "
            f"and a pattern has at most {MOST_COPIES} characters with all written out"
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


def _size_at_most(pattern: str) -> int:
    """Return how long a pattern is at most with its repetitions written out.

    What stands before a repetition is one character or set, unless a group or another repetition
    ends there: then it may be all that came before. Those that are escaped count, too.

    >>> _size_at_most("^box_[0-9]{3}$")
    17
    """
    size, factor = len(pattern), 1
    for repetition in _REPETITION.finditer(pattern):
        numbers = [int(digits[:9]) for digits in re.findall("[0-9]+", repetition[1] or "")]
        copies = max([2, *numbers])
        if pattern[: repetition.start()].endswith((")", "*", "+", "?", "}")):
            factor *= copies
        else:
            size += copies
    return size * factor
