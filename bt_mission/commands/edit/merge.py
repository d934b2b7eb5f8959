"""Two versions of a text and the one that both began with, side by side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from bt_mission.commands.edit.common_lines import common_lines


@dataclass(frozen=True)
class Hunk:
    """Lines of a text in three versions, with their line feeds.

    Attributes:
        base: The lines with which both versions began.
        theirs: The lines on disk.
        mine: The lines in the editor.
    """

    base: str
    theirs: str
    mine: str

    @property
    def choice(self) -> str:
        """The version to take: `mine`, `theirs`, or empty where both have changed the lines."""
        if self.mine in (self.base, self.theirs):
            return "theirs"
        return "mine" if self.theirs == self.base else ""


def hunks(base: str, theirs: str, mine: str) -> tuple[Hunk, ...]:
    """Return a text in three versions, cut where one of them differs from another.

    A version with too many lines that are alike between its changes is compared as a whole.
    """
    texts = tuple(text.splitlines(keepends=True) for text in (base, theirs, mine))
    ends = tuple(map(len, texts))
    starts, merged = (0, 0, 0), list[Hunk]()
    for places, size in (*_common(*texts), (ends, 0)):
        if places != starts:
            merged.append(_hunk(texts, starts, places))
        stops = (places[0] + size, places[1] + size, places[2] + size)
        if size:
            merged.append(_hunk(texts, places, stops))
        starts = stops
    return tuple(merged)


def _hunk(texts: Sequence[Sequence[str]], starts: Sequence[int], ends: Sequence[int]) -> Hunk:
    base, theirs, mine = (
        "".join(lines[start:end]) for lines, start, end in zip(texts, starts, ends, strict=True)
    )
    return Hunk(base, theirs, mine)


def _common(
    base: Sequence[str], theirs: Sequence[str], mine: Sequence[str]
) -> Iterator[tuple[tuple[int, int, int], int]]:
    """Yield where all three versions have the same lines, and their number."""
    first, second = common_lines(base, theirs) or (), common_lines(base, mine) or ()
    at, other = 0, 0
    while at < len(first) and other < len(second):
        (left, in_theirs, left_size), (right, in_mine, right_size) = first[at], second[other]
        start = max(left, right)
        end = min(left + left_size, right + right_size)
        if end > start:
            yield (start, in_theirs + start - left, in_mine + start - right), end - start
        if left + left_size < right + right_size:
            at += 1
        else:
            other += 1
