"""Which part of a long list is in view."""

from __future__ import annotations

from collections.abc import Sequence


def scrolled_to(row: int, above: Sequence[int], top: int, height: int, count: int) -> int:
    """The first row in view, so that a row is, and with it as many of those above as fit.

    What need not move does not: while the row and all that fits above it are in view, the rest
    stays where it is.

    :param above: rows that belong to it, the farthest first, such as its ancestors'.
    :param top: the first row in view until now.
    :param height: rows in view; count: of the whole list.
    """
    if height <= 0:
        return 0
    fitting = [one for one in above if row - one < height]
    highest = fitting[0] if fitting else row
    top = min(top, highest)
    top = max(top, row - height + 1)
    return max(min(top, count - height), 0)
