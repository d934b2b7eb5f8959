"""One way through what may happen: which option was taken wherever there were several."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

UNBOUNDED = math.inf
"""The number of faults without a bound."""


class Option(NamedTuple):
    """One thing that may happen.

    Attributes:
        words: What happens, for people; "" for nothing worth a line.
        faults: 0 where it is usual, 1 where it is a fault of the environment.
        act: Makes it happen; None where the caller does so.
    """

    words: str
    faults: int = 0
    act: Callable[[], None] | None = None


NOTHING = Option("")

_NONE: tuple[int, ...] = ()

Script = tuple[int, ...]
"""The options taken, in the order in which they were offered."""


class OutOfFaultsError(Exception):
    """No option remains within the bound on faults."""


class Choices:
    """Takes options by a script; behind its end the first that is allowed.

    Args:
        faults_left: How many faults may still happen.
    """

    def __init__(self, faults_left: float = UNBOUNDED) -> None:
        self.faults_left = faults_left
        self.words: list[str] = []
        """What has happened since :meth:`begin`."""
        self._script: Script = ()
        self._taken: list[int] = []
        self._allowed: list[tuple[int, ...]] = []
        """The options that were allowed at each place behind the script."""

    def begin(self, script: Script) -> None:
        """Follow a script from now on."""
        self._script, self._taken, self._allowed, self.words = script, [], [], []

    @property
    def taken(self) -> Script:
        """The options taken since :meth:`begin`."""
        return tuple(self._taken)

    def choose(self, options: Sequence[Option]) -> int:
        """Take an option; return its index.

        Raises:
            OutOfFaultsError: When each is a fault too many.
        """
        position, allowed = len(self._taken), _NONE
        if position < len(self._script):
            index = self._script[position]
        else:
            left = self.faults_left
            allowed = tuple(
                [index for index, option in enumerate(options) if option.faults <= left]
            )
            if not allowed:
                raise OutOfFaultsError
            index = allowed[0]
        self._taken.append(index)
        self._allowed.append(allowed)
        self.pay(options[index].faults)
        if options[index].words:
            self.words.append(options[index].words)
        return index

    def pay(self, faults: int) -> None:
        """Count faults that nobody chose. Raises OutOfFaultsError when they are too many."""
        if faults > self.faults_left:
            raise OutOfFaultsError
        self.faults_left -= faults

    def others(self) -> Iterator[Script]:
        """Yield the scripts that leave this one behind the end of its given part."""
        for position in range(len(self._script), len(self._taken)):
            for index in self._allowed[position]:
                if index != self._taken[position]:
                    yield (*self._taken[:position], index)
