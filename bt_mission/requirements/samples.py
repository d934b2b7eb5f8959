"""The value of a formula at one instant: true or false, and its margin."""

from __future__ import annotations

import math
from collections.abc import Iterable
from enum import Enum
from typing import TypeAlias

Value: TypeAlias = tuple[float, bool, int, int]
"""Margin in the unit of the signal; whether the formula is true; the instant that decides, ns; the
number of the comparison that decides."""

Sample: TypeAlias = Value | None
"""None while a signal has no value yet."""


class Truncation(Enum):
    """How windows that the end of the run cuts off are evaluated.

    The views of truncated paths of Eisner et al., "Reasoning with temporal logic on truncated
    paths" (2003).
    """

    NEUTRAL = "neutral"
    """The formula is evaluated over the instants of the run alone."""
    WEAK = "weak"
    """Open claims count as true at the end."""
    WEAK_AFTER_MISSION = "weak after mission"
    """The same, but the mission has ended: what depends on its signals alone does not change."""
    STRONG = "strong"
    """Open claims count as false at the end."""
    STRONG_AFTER_MISSION = "strong after mission"
    """The same, but the mission has ended."""

    def fulfils(self, *, is_settled_by_end: bool) -> bool:
        """Return whether a formula comes true after the end.

        Args:
            is_settled_by_end: Does the formula not change once the mission has ended?
        """
        return self is Truncation.WEAK or (
            self is Truncation.WEAK_AFTER_MISSION and not is_settled_by_end
        )

    def refutes(self, *, is_settled_by_end: bool) -> bool:
        """Return whether a formula that is true so far becomes false after the end.

        Args:
            is_settled_by_end: See :meth:`fulfils`.
        """
        return self is Truncation.STRONG or (
            self is Truncation.STRONG_AFTER_MISSION and not is_settled_by_end
        )


def true_at(now_ns: int) -> Value:
    """Return the value of what is true whatever the signals are."""
    return math.inf, True, now_ns, -1


def false_at(now_ns: int) -> Value:
    """Return the value of what is false whatever the signals are."""
    return -math.inf, False, now_ns, -1


def negated(value: Value) -> Value:
    """Return the value of the negation."""
    return -value[0], not value[1], value[2], value[3]


def least(first: Value, second: Value) -> Value:
    """Return the value with the smaller margin; the first of two that are equal."""
    margin, bound = first[0], second[0]
    return first if margin < bound or (margin == bound and first[1] <= second[1]) else second


def most(first: Value, second: Value) -> Value:
    """Return the value with the greater margin; the first of two that are equal."""
    margin, bound = first[0], second[0]
    return first if margin > bound or (margin == bound and first[1] >= second[1]) else second


def joined(samples: Iterable[Sample], *, all_of: bool) -> Sample:
    """Return `and` or `or` of samples; None where one without a value may decide."""
    pick = least if all_of else most
    value: Sample = None
    is_known = True
    for sample in samples:
        if sample is None:
            is_known = False
        else:
            value = sample if value is None else pick(value, sample)
    return value if is_known or (value is not None and value[1] is not all_of) else None


def extreme(samples: Iterable[Sample], *, all_of: bool) -> Sample:
    """Return the least, or the most, of those samples that have a value; None without any."""
    return joined([sample for sample in samples if sample is not None], all_of=all_of)
