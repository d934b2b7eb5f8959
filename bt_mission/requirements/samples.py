"""What a formula is worth at one instant: true or false, and by how much."""

from __future__ import annotations

import math
from collections.abc import Iterable
from enum import Enum
from typing import TypeAlias

Value: TypeAlias = tuple[float, bool, int, int]
"""Margin in the unit of the signal; whether it holds; the instant that decides, ns; the number of
the comparison that decides."""

Sample: TypeAlias = Value | None
"""None while a signal has no value yet."""


class Hope(Enum):
    """What is taken for granted to come about behind the end of a run, in windows cut off by it."""

    NOTHING = "nothing"
    ROBOT = "robot"
    """What the robot does; the mission has ended, and nothing in it changes any more."""
    ANYTHING = "anything"
    """The run was cut: the mission might have gone on, too."""
    WORST = "worst"
    """The run was cut, and whatever can go wrong then does."""

    def reaches(self, *, is_settled_by_end: bool) -> bool:
        """Is it taken for granted, for a formula of the mission alone, or another one?"""
        return self is Hope.ANYTHING or (self is Hope.ROBOT and not is_settled_by_end)


def holds(now_ns: int) -> Value:
    """What holds whatever the signals are."""
    return math.inf, True, now_ns, -1


def fails(now_ns: int) -> Value:
    """What fails whatever the signals are."""
    return -math.inf, False, now_ns, -1


def negated(one: Value) -> Value:
    """Return the value of what holds where this does not."""
    return -one[0], not one[1], one[2], one[3]


def least(one: Value, other: Value) -> Value:
    """The one that holds by less; the first of two that are equal."""
    margin, bound = one[0], other[0]
    return one if margin < bound or (margin == bound and one[1] <= other[1]) else other


def most(one: Value, other: Value) -> Value:
    """The one that holds by more; the first of two that are equal."""
    margin, bound = one[0], other[0]
    return one if margin > bound or (margin == bound and one[1] >= other[1]) else other


def joined(samples: Iterable[Sample], *, all_of: bool) -> Sample:
    """Return `and` or `or` of samples; None where one without a value may decide."""
    pick = least if all_of else most
    found: Sample = None
    is_known = True
    for one in samples:
        if one is None:
            is_known = False
        else:
            found = one if found is None else pick(found, one)
    return found if is_known or (found is not None and found[1] is not all_of) else None


def extreme(samples: Iterable[Sample], *, all_of: bool) -> Sample:
    """Return the value over time of those samples that have one; None where none has."""
    known = [one for one in samples if one is not None]
    return joined(known, all_of=all_of)
