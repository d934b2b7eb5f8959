"""Facts about the check of a goal field."""

from __future__ import annotations

import math

import numpy as np
import pytest

from action_servers.core.limits import first_fault, outside


@pytest.mark.parametrize("value", [0.05, 1.0, 1.82, float(np.float32(1.82))])
def test_both_limits_belong_to_the_range(value):
    """As float32 rounds them, too."""
    assert outside("speed", value, 0.05, 1.82, "rad/s") is None


@pytest.mark.parametrize("value", [0.049, 1.8201, math.nan, math.inf, -math.inf, 1e300])
def test_what_is_outside_is_told_with_limits_and_unit(value):
    """Expected and got, in one line."""
    assert outside("speed", value, 0.05, 1.82, "rad/s") == (
        f"speed must be from 0.05 to 1.82 rad/s, got {value:g}"
    )


def test_the_first_fault_is_told():
    """None when there is none."""
    assert first_fault(None, "a", "b") == "a"
    assert first_fault(None, None) is None
