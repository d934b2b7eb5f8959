from __future__ import annotations

import pytest

from bt_mission.scenarios.statistics import wilson


@pytest.mark.parametrize(
    ("passed", "total", "low", "high"),
    [
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
        (20, 20, 0.8389, 1.0),
    ],
)
def test_the_interval_is_wilsons(passed, total, low, high):
    """The values of table I in R. G. Newcombe, Statistics in Medicine 17 (1998), 857-872."""
    assert wilson(passed, total) == pytest.approx((low, high), abs=5e-5)
