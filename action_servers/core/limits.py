"""Checks of single goal fields: every refusal says what was expected and what was got."""

from __future__ import annotations

import math

# A goal field is a float32: 1.82 arrives as 1.8200000525, and must still be within 1.82.
FLOAT32_ROUNDING = 1e-6


def outside(name: str, value: float, low: float, high: float, unit: str) -> str | None:
    """Return why `value` is no number from `low` to `high`, or None when it is one.

    NaN and infinities are always outside. Both limits belong to the range.
    """
    low_slack = FLOAT32_ROUNDING * abs(low)
    high_slack = FLOAT32_ROUNDING * abs(high)
    if math.isfinite(value) and low - low_slack <= value <= high + high_slack:
        return None
    return f"{name} must be from {low:g} to {high:g} {unit}, got {value:g}"


def first_fault(*faults: str | None) -> str | None:
    """Return the first fault that is not None, or None."""
    return next((fault for fault in faults if fault is not None), None)
