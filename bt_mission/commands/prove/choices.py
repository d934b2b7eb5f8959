"""One way through what may happen: which option was taken wherever there were several."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

UNBOUNDED = math.inf
"""The number of faults without a bound."""


class Possibility(NamedTuple):
    """One thing that may happen.

    Attributes:
        words: What happens, for people; "" for nothing worth a line.
        faults: 0 where it is usual, 1 where it is a fault of the environment.
        act: Makes it happen; None where the caller does so.
        is_event: Does it make a difference when it happens?
    """

    words: str
    faults: int = 0
    act: Callable[[], None] | None = None
    is_event: bool = True


NOTHING = Possibility("")

NEVER = math.inf
"""The faults of what never happens."""

Script = tuple[int, ...]
"""The options taken, in the order in which they were offered."""


class Chosen(NamedTuple):
    """An option that was taken.

    Attributes:
        costs: The faults of each option that there was.
        taken: The index of the one that was taken; -1 where each is a fault too many.
    """

    costs: tuple[int, ...]
    taken: int


class Met(NamedTuple):
    """Time that has passed up to the next tick.

    Attributes:
        limits: Those that were running before the step and still are, by their index.
        are_over: Of each of them; or, where that is asked, whether it is over first.
        faults: What it costs.
        is_order: Is it asked which of them are over first?
    """

    limits: tuple[int, ...]
    are_over: tuple[bool, ...]
    faults: float
    is_order: bool = False


Turn = Chosen | Met
"""A place at which a step depends on more than the state without its times."""


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
        self.trail: list[Turn] = []
        """What the way since :meth:`begin` depends on, in its order."""
        self._script: Script = ()
        self._taken: list[int] = []
        self._allowed: list[Sequence[int]] = []
        """The options that were allowed at each place behind the script."""

    def begin(self, script: Script) -> None:
        """Follow a script from now on."""
        self._script, self._taken, self._allowed, self.words = script, [], [], []
        self.trail = []

    @property
    def taken(self) -> Script:
        """The options taken since :meth:`begin`."""
        return tuple(self._taken)

    def choose(self, options: Sequence[Possibility]) -> int:
        """Take an option; return its index.

        Raises:
            OutOfFaultsError: When each is a fault too many.
        """
        position = len(self._taken)
        allowed: Sequence[int] = ()
        costs = tuple([option.faults for option in options])
        if position < len(self._script):
            index = self._script[position]
        else:
            allowed = affordable(costs, self.faults_left)
            index = allowed[0] if allowed else -1
        self.trail.append(Chosen(costs, index))
        if index < 0:
            raise OutOfFaultsError
        self._taken.append(index)
        self._allowed.append(allowed)
        self.pay(options[index].faults)
        if options[index].words:
            self.words.append(options[index].words)
        return index

    def meet(
        self,
        limits: tuple[int, ...],
        are_over: tuple[bool, ...],
        faults: float,
        *,
        is_order: bool = False,
    ) -> None:
        """Note which limits are over, or over first, and count their faults.

        Raises:
            OutOfFaultsError: When they are too many, or a server is late that never is.
        """
        self.trail.append(Met(limits, are_over, faults, is_order))
        self.pay(faults)

    def pay(self, faults: float) -> None:
        """Count faults. Raises OutOfFaultsError when they are too many, or infinite."""
        if faults > self.faults_left or faults == NEVER:
            raise OutOfFaultsError
        self.faults_left -= faults

    def others(self) -> Iterator[Script]:
        """Yield the scripts that leave this one behind the end of its given part."""
        return leaving(self._taken, self._allowed, len(self._script))


def affordable(costs: Sequence[int], faults_left: float) -> list[int]:
    """Return the options that are within the bound on faults."""
    return [index for index, cost in enumerate(costs) if cost <= faults_left]


def leaving(taken: Sequence[int], allowed: Sequence[Sequence[int]], given: int) -> Iterator[Script]:
    """Yield the scripts that leave a way behind its given part, the earliest first.

    Args:
        taken: The way.
        allowed: The options at each of its places.
        given: The number of its first options that were given.
    """
    for position in range(given, len(taken)):
        for index in allowed[position]:
            if index != taken[position]:
                yield (*taken[:position], index)
