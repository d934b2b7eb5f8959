"""The lines that two versions of a text have in common, found in little time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from difflib import SequenceMatcher

MOST_PAIRS = 2_000_000
"""Pairs of the same line, one in either version, between the first and the last change. The search
takes time for each of them: many lines that differ are fast, many that are alike are not.
"""

Block = tuple[int, int, int]
"""The first of some lines in either version, and their number."""


def common_lines(before: Sequence[str], after: Sequence[str]) -> list[Block] | None:
    """Return the blocks of lines that two versions have in common, in their order.

    None if too many lines between the first and the last change are alike.
    """
    most = min(len(before), len(after))
    first = 0
    while first < most and before[first] == after[first]:
        first += 1
    last = 0
    while last < most - first and before[-1 - last] == after[-1 - last]:
        last += 1
    old, new = before[first : len(before) - last], after[first : len(after) - last]
    counts = Counter(new)
    if sum(counts[line] for line in old) > MOST_PAIRS:
        return None
    between = SequenceMatcher(None, old, new, autojunk=False).get_matching_blocks()
    return [
        (0, 0, first),
        *((first + a, first + b, size) for a, b, size in between if size),
        (len(before) - last, len(after) - last, last),
    ]
