"""Rows as arrays, and which of them are worth a look."""

from __future__ import annotations

import numpy as np

from bt_mission.sweeps.columns import PLAN, SweepColumns
from tests.sweeps.conftest import write_results
from tests.sweeps.rows import failed, margin, row


def test_columns_have_a_value_for_each_row():
    """Also where rows have other parameters and requirements than those before them."""
    columns = SweepColumns(
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
    columns = SweepColumns([row(0, requirements={"clear": margin(float("inf"))})])
    assert np.isnan(columns.margins("clear")).all()


# ---- the worst -----------------------------------------------------------------------------


def ids(rows, most=20):
    """The numbers of the worst of some rows."""
    return [int(row_id, 16) for row_id in SweepColumns(rows).worst(most)]


def test_failed_runs_come_first():
    """However small the margins of those that have passed are."""
    rows = [row(0, requirements={"clear": margin(0.01)}), failed(1), row(2)]
    assert ids(rows) == [1, 0, 2]


def test_the_smallest_margin_is_the_worst():
    """Of runs that have passed."""
    rows = [
        row(n, requirements={"clear": margin(first)}) for n, first in enumerate((0.3, 0.1, 0.2))
    ]
    assert ids(rows, 2) == [1, 2]


def test_metres_and_seconds_are_compared_by_their_means():
    """5 s of about 50 are nearer to a violation than 0.4 m of about 0.5."""
    rows = [
        row(n, requirements={"clear": margin(metres), "in time": margin(seconds, unit="s")})
        for n, (metres, seconds) in enumerate(((0.4, 50.0), (0.6, 5.0), (0.5, 55.0)))
    ]
    assert ids(rows, 1) == [1]


def test_a_margin_that_is_always_the_same_tells_nothing():
    """A requirement without collisions has the margin 0 in every run."""
    rows = [
        row(n, requirements={"no collision": margin(0.0, unit=""), "clear": margin(first)})
        for n, first in enumerate((0.3, 0.1, 0.2))
    ]
    assert ids(rows) == [1, 2, 0]


def test_the_requirement_that_counts_is_named():
    """Its margin is the one that is shown."""
    rows = [
        row(n, requirements={"clear": margin(metres), "late": margin(first), "same": margin(0.0)})
        for n, (metres, first) in enumerate(((0.4, 50.0), (0.6, 5.0), (0.5, 55.0)))
    ]
    result = SweepColumns(rows)
    assert [result.nearest(known) for known in rows] == ["clear", "late", "clear"]
    assert result.nearest(row(9)) is None


def test_a_frequent_failure_does_not_hide_a_rare_one():
    """Of each kind of failure one is taken in turn."""
    rows = [failed(n) for n in range(50)]
    rows.append(failed(50, reason="the base is worn out", failed_node="drive"))
    assert ids(rows, 2) == [0, 50]


def test_what_could_not_run_is_left_out():
    """It has no run that could be recorded."""
    assert ids([row(0, outcome="error", passed=False)]) == []


def test_runs_without_a_margin_are_the_best():
    """Nothing is known that was near to going wrong."""
    rows = [row(0), *(row(n, requirements={"clear": margin(n / 10)}) for n in (2, 1))]
    assert ids(rows) == [1, 2, 0]


def test_the_rows_are_read_from_the_results(tmp_path):
    """In the order of the ids."""
    store = write_results(tmp_path / "r", [row(0), failed(1), failed(2)], None)
    assert [worst.number for worst in SweepColumns(store.rows()).worst_rows(store, 2)] == [1, 2]
