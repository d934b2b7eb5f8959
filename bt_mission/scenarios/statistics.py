"""Success rates with their intervals, and runs that count as one sample."""

from __future__ import annotations

import math

Z_95 = 1.959964
"""The number of standard deviations on each side that cover 95 % of a normal distribution."""


def wilson(passed: int, total: int, samples: int | None = None) -> tuple[float, float]:
    """The 95 % confidence interval of the rate of passes.

    Also where all pass or none does, and for few trials, it says something: of 20 out of 20, that
    the true rate is 84 % or more. The formula is that of E. B. Wilson, "Probable inference, the
    law of succession, and statistical inference", Journal of the American Statistical Association
    22 (1927), 209-212.

    Args:
        total: At least 1.
        samples: How many of the trials are distinct, from 1 to `total`; None is all. The rate is
            that of all trials, and the interval is as wide as for this many.
    """
    rate, z, count = passed / total, Z_95, total if samples is None else samples
    spread = z * z / count
    centre = rate + spread / 2
    half = z * math.sqrt(rate * (1 - rate) / count + spread / (4 * count))
    low, high = (centre - half) / (1 + spread), (centre + half) / (1 + spread)
    return max(low, 0.0), min(high, 1.0)


def samples_as_text(runs: int, samples: int, varied: str = "the seed") -> str:
    """Return the number of distinct runs as text; empty if all are.

    Args:
        varied: The difference between the runs.
    """
    if samples == runs:
        return ""
    if samples == 1:
        return f"{runs:,} runs, 1 distinct: {varied} changes nothing"
    return f"{runs:,} runs, {samples:,} distinct: identical runs count as one"
