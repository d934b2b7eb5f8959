"""The source of choices: a seeded generator, or hypothesis."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Protocol, TypeVar

T = TypeVar("T")


class Draws(Protocol):
    """Draws whole numbers; everything else derives from them, so that it shrinks well."""

    def whole(self, low: int, high: int) -> int:
        """Return a number from ``low`` to ``high``, both included; lower is simpler."""


class SeededDraws:
    """Draws from a separate generator.

    Args:
        seed: Equal seeds give equal draws.
    """

    def __init__(self, seed: int | str) -> None:
        self._generator = random.Random(f"drawn/{seed}")

    def whole(self, low: int, high: int) -> int:
        """A number from ``low`` to ``high``, both included, all as likely."""
        return self._generator.randint(low, high)


def one_of(draws: Draws, choices: Sequence[T]) -> T:
    """Return one of these; the first is the simplest."""
    return choices[draws.whole(0, len(choices) - 1)]


def number(draws: Draws, low: float, high: float, step: float) -> float:
    """Return one of ``low``, ``low + step``, ... up to ``high``."""
    return round(low + step * draws.whole(0, round((high - low) / step)), 6)


def maybe(draws: Draws, one_in: int) -> bool:
    """Return True once in `one_in` times; False is simpler."""
    return draws.whole(0, one_in - 1) == one_in - 1
