"""Rows as arrays, and which of them are worth a look."""

from __future__ import annotations

import numpy as np
import pytest

from bt_mission.sweeps.columns import PLAN, SweepColumns
from tests.sweeps.conftest import write_results
from tests.sweeps.rows import failed, margin, row


def test_columns_have_a_value_for_each_row():
    """Also where rows have other parameters and requirements; an infinite margin is none."""
    columns = SweepColumns(
        [
            row(0, parameters={"speed": 0.1}),
            failed(1, parameters={"world": "hall"}, plan="lost"),
            row(2, requirements={"clear": margin(0.5)}),
            row(3, requirements={"clear": margin(float("inf"))}, outcome="error", passed=False),
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


# ---- the worst -----------------------------------------------------------------------------


def clear(*metres, **others):
    """Rows with these margins of one requirement, and some of others."""
    return [
        row(
            n,
            requirements={"clear": margin(first)} | {name: its[n] for name, its in others.items()},
        )
        for n, first in enumerate(metres)
    ]


@pytest.mark.parametrize(
    ("rows", "most", "order"),
    [
        ([*clear(0.01), failed(1), row(2)], 20, [1, 0, 2]),
        (clear(0.3, 0.1, 0.2), 2, [1, 2]),
        (clear(0.4, 0.6, 0.5, late=[margin(s, unit="s") for s in (50.0, 5.0, 55.0)]), 1, [1]),
        (clear(0.3, 0.1, 0.2, no_collision=[margin(0.0, unit="")] * 3), 20, [1, 2, 0]),
        (
            [
                *map(failed, range(50)),
                failed(50, reason="the base is worn out", failed_node="drive"),
            ],
            2,
            [0, 50],
        ),
        ([row(0, outcome="error", passed=False)], 20, []),
        ([*clear(0.2, 0.1), row(2)], 20, [1, 0, 2]),
    ],
    ids=[
        "failed runs come first, however small the margins of the others are",
        "the smallest margin is the worst",
        "metres and seconds are compared by their means",
        "a margin that is always the same tells nothing",
        "a frequent failure does not hide a rare one",
        "what could not run is left out",
        "runs without a margin are the best",
    ],
)
def test_the_worst_come_first(rows, most, order):
    """Of each kind of failure one is taken in turn, then the smallest margins."""
    assert [int(row_id, 16) for row_id in SweepColumns(rows).worst(most)] == order


def test_the_requirement_that_counts_is_named():
    """Its margin is the one that is shown."""
    late = [margin(seconds) for seconds in (50.0, 5.0, 55.0)]
    rows = clear(0.4, 0.6, 0.5, late=late, same=[margin(0.0)] * 3)
    result = SweepColumns(rows)
    assert [result.nearest(known) for known in rows] == ["clear", "late", "clear"]
    assert result.nearest(row(9)) is None


def test_the_rows_are_read_from_the_results(tmp_path):
    """In the order of the ids."""
    store = write_results(tmp_path / "r", [row(0), failed(1), failed(2)], None)
    assert [worst.number for worst in SweepColumns(store.rows()).worst_rows(store, 2)] == [1, 2]
