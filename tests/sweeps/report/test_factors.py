"""How success depends on what was varied."""

from __future__ import annotations

import numpy as np
import pytest

from bt_mission.core.statistics import wilson
from bt_mission.sweeps.columns import SweepColumns
from bt_mission.sweeps.report.factors import (
    MOST_LEVELS,
    MOST_NAMES,
    factor,
    factors_of,
    pairs_of,
    round_edges,
)
from tests.sweeps.rows import failed, row


def passes(*values):
    """Rows that all differ: whether each has passed."""
    return SweepColumns([row(n) if first else failed(n) for n, first in enumerate(values)])


def test_each_number_is_a_level():
    """By size, with its rate and the interval of that."""
    made = factor("speed", [0.2, 0.1, 0.2, 0.2], passes(1, 0, 0, 1))
    assert made.is_number
    assert [(level.label, level.passed, level.total) for level in made.levels] == [
        ("0.1", 0, 1),
        ("0.2", 2, 3),
    ]
    assert made.levels[1].interval == wilson(2, 3)
    assert made.indices.tolist() == [1, 0, 1, 1]


def test_identical_rows_of_a_level_are_one_sample():
    """The rate is that of all rows, the interval as wide as for the distinct ones."""
    results = SweepColumns(
        [row(0, sample="5"), row(1, sample="5"), row(2, sample="6"), failed(3, sample="5")]
    )
    first, second = factor("speed", [0.1, 0.1, 0.1, 0.2], results).levels
    assert (first.total, first.samples, second.samples) == (3, 2, 1)
    assert first.interval == wilson(3, 3, 2)


def test_of_many_numbers_stretches_are_levels():
    """With round ends; each row is in one of them, the greatest too."""
    values = np.linspace(0.05, 0.25, 1000)
    made = factor("speed", values.tolist(), passes(*values > 0.1))
    assert len(made.levels) <= MOST_LEVELS
    assert (made.levels[0].label, made.levels[-1].label) == ("0.04\u20130.06", "0.24\u20130.26")
    assert sum(level.total for level in made.levels) == 1000
    assert made.levels[0].rate == 0
    assert made.levels[-1].rate == 1


def test_stretches_without_a_row_are_left_out():
    """There is no rate of nothing."""
    values = [*np.linspace(0, 1, 50), *np.linspace(9, 10, 50)]
    made = factor("x", values, passes(*[1] * 100))
    assert [level.label for level in made.levels] == ["0\u20131", "1\u20132", "9\u201310"]


def test_truth_is_no_number():
    """It has two names."""
    made = factor("quiet", [True, False, True], passes(1, 1, 0))
    assert not made.is_number
    assert [level.label for level in made.levels] == ["true", "false"]


def test_rows_without_the_parameter_are_in_no_level():
    """As those that an error has no value of."""
    made = factor("world", ["hall", None], passes(1, 1))
    assert made.indices.tolist() == [0, -1]
    assert made.levels[0].total == 1


def test_of_very_many_names_the_worst_are_shown():
    """And it is known that others are not."""
    names = [f"w{number:03}" for number in range(MOST_NAMES * 2)]
    made = factor("world", names, passes(*(number % 2 for number in range(len(names)))))
    assert made.is_cut
    assert len(made.levels) == MOST_NAMES
    assert not any(level.passed for level in made.levels)


def test_what_has_one_value_is_not_varied():
    """It has no chart."""
    columns = SweepColumns(row(n, parameters={"a": 1, "b": n % 2}) for n in range(4))
    assert [varied.name for varied in factors_of(columns)] == ["b"]
    assert pairs_of(columns) == ([], 0)


def test_pairs_count_each_cell():
    """Rows are levels of the second parameter, columns those of the first."""
    rows = [
        row(n, parameters={"a": a, "b": b}, passed=a == b)
        for n, (a, b) in enumerate(((0, 0), (0, 1), (0, 2), (1, 1), (1, 1)))
    ]
    ((pair,), left_out) = pairs_of(SweepColumns(rows))
    assert left_out == 0
    assert pair.total.tolist() == [[1, 0], [1, 2], [1, 0]]
    assert pair.passed.tolist() == [[1, 0], [0, 2], [0, 0]]


def test_the_pairs_that_tell_most_come_first():
    """That is where two parameters together decide what neither does alone."""
    rows = [
        row(n, parameters={"idle": n % 2, "a": n // 2 % 2, "b": n // 4 % 2},
            passed=(n // 2 % 2) != (n // 4 % 2))
        for n in range(8)
    ]  # fmt: skip
    (pair,), left_out = pairs_of(SweepColumns(rows), most=1)
    assert (pair.first.name, pair.second.name, left_out) == ("a", "b", 2)


@pytest.mark.parametrize(
    ("low", "high", "most"),
    [(0.05, 0.26, 9), (-1.3, 2.0, 12), (1e-9, 3e-9, 8), (0, 1e6, 40), (3, 3, 12)],
)
def test_ends_of_stretches_are_round(low, high, most):
    """They hold all values, are few enough, and 0 is one of them if it lies between."""
    edges = round_edges(low, high, most)
    assert edges[0] <= low
    assert edges[-1] >= high * (1 - 1e-9)
    assert len(edges) - 1 <= most
    if low <= 0 <= high:
        assert 0 in edges
