"""Rates, with how certain they are."""

from __future__ import annotations

import math

Z_95 = 1.959964
"""So many standard deviations to each side hold 95 % of a normal distribution."""


def wilson(passed: int, total: int) -> tuple[float, float]:
    """The interval that holds the true rate of passes with a certainty of 95 %.

    Also where all pass or none does, and for few trials, it says something: of 20 out of 20, that
    the true rate is 84 % or more. The formula is that of E. B. Wilson, "Probable inference, the
    law of succession, and statistical inference", Journal of the American Statistical Association
    22 (1927), 209-212.

    Args:
        total: At least 1.
    """
    rate, z = passed / total, Z_95
    spread = z * z / total
    centre = rate + spread / 2
    half = z * math.sqrt(rate * (1 - rate) / total + spread / (4 * total))
    low, high = (centre - half) / (1 + spread), (centre + half) / (1 + spread)
    return max(low, 0.0), min(high, 1.0)
