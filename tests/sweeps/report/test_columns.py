"""What the page needs of every row."""

from __future__ import annotations

import numpy as np

from bt_mission.sweeps.report.columns import PLAN, SweepColumns
from tests.sweeps.rows import failed, margin, row


def test_columns_have_a_value_for_each_row():
    """Also where rows have other parameters and requirements than those before them."""
    columns = SweepColumns.of(
        [
            row(0, parameters={"speed": 0.1}),
            failed(1, parameters={"world": "hall"}, plan="lost"),
            row(2, requirements={"clear": margin(0.5)}),
            row(3, outcome="error", passed=False),
        ]
    )
    assert columns.values == {
        "speed": [0.1, None, None, None],
        "world": [None, "hall", None, None],
        PLAN: [None, "lost", None, None],
    }
    assert np.array_equal(columns.margins("clear"), [np.nan, np.nan, 0.5, np.nan], equal_nan=True)
    assert columns.passed.tolist() == [True, False, True, False]
    assert columns.ran.tolist() == [True, True, True, False]
    assert columns.seconds.tolist() == [20.0, 2.95, 20.0, 20.0]


def test_a_margin_that_is_not_finite_is_none():
    """A picture has no place for it."""
    columns = SweepColumns.of([row(0, requirements={"clear": margin(float("inf"))})])
    assert np.isnan(columns.margins("clear")).all()
