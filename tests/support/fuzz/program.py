"""Cases that are programs of bytes: what happens next is read from them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

T = TypeVar("T")


class Program:
    """Hands out bytes, and what they choose; at its end there are zeros.

    A case is made smaller by leaving bytes out.
    """

    def __init__(self, contents: bytes) -> None:
        self._contents = contents
        self._at = 0

    def __bool__(self) -> bool:
        return self._at < len(self._contents)

    def byte(self) -> int:
        """Return the next byte."""
        self._at += 1
        return self._contents[self._at - 1] if self._at <= len(self._contents) else 0

    def pick(self, choices: Sequence[T]) -> T:
        """Return one of these."""
        return choices[self.byte() % len(choices)]

    def chance(self, share: float) -> bool:
        """Return true in so many cases, as a share of 1."""
        return self.byte() < 256 * share
