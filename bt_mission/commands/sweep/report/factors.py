"""Success by what was varied: levels of a parameter, and pairs of parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Any

import numpy as np

from bt_mission.commands.sweep.columns import Counts, Floats, SweepColumns
from bt_mission.scenarios.statistics import wilson

MOST_LEVELS = 16
"""Numbers that each have a level; with more, ranges are the levels."""
STRETCHES = 12
MOST_CELLS = 9
"""Levels of a number in a map of two parameters."""
MOST_NAMES = 40
EN_DASH = "\u2013"
MOST_MAPS = 6


@dataclass(frozen=True)
class Level:
    """One value of a parameter, or a range of them, with the results of the runs there.

    Attributes:
        samples: How many of the runs are distinct; None is all.
    """

    label: str
    at: float
    passed: int
    total: int
    samples: int | None = None

    @property
    def rate(self) -> float:
        """The share that passed."""
        return self.passed / self.total

    @property
    def interval(self) -> tuple[float, float]:
        """The Wilson interval of the share."""
        return wilson(self.passed, self.total, self.samples)


@dataclass(frozen=True)
class Factor:
    """A parameter with the runs at each of its levels.

    Attributes:
        is_number: Whether its levels are numbers.
        indices: The level of each row; -1 without one.
        is_cut: Whether names were omitted.
    """

    name: str
    is_number: bool
    levels: tuple[Level, ...]
    indices: Counts
    is_cut: bool = False

    @property
    def spread(self) -> float:
        """The difference of the success between levels: the variance that they explain."""
        totals = np.array([level.total for level in self.levels])
        rates = np.array([level.rate for level in self.levels])
        return float(np.average((rates - np.average(rates, weights=totals)) ** 2, weights=totals))


def factor(
    name: str, values: Sequence[Any], columns: SweepColumns, most_levels: int = MOST_LEVELS
) -> Factor:
    """Return a parameter's levels.

    Args:
        values: One for each row; None for a row without one.
        most_levels: The number of numbers that have a level each.
    """
    known = [value for value in values if value is not None]
    if known and all(
        isinstance(value, int | float) and not isinstance(value, bool) for value in known
    ):
        return _of_numbers(name, values, columns, most_levels)
    return _of_names(name, values, columns)


def _of_numbers(
    name: str, values: Sequence[Any], columns: SweepColumns, most_levels: int
) -> Factor:
    numbers = np.array([np.nan if value is None else value for value in values], np.float64)
    is_known = np.isfinite(numbers)
    distinct, indices = np.unique(numbers[is_known], return_inverse=True)
    at, labels = distinct, [short(value) for value in distinct]
    if len(distinct) > most_levels:
        edges = round_edges(distinct[0], distinct[-1], min(STRETCHES, most_levels))
        indices = np.searchsorted(edges, numbers[is_known], side="right") - 1
        indices = np.minimum(indices, len(edges) - 2)
        at = (edges[1:] + edges[:-1]) / 2
        dash = EN_DASH if edges[0] >= 0 else " to "
        labels = [f"{short(low)}{dash}{short(high)}" for low, high in pairwise(edges)]
    everywhere = np.full(len(numbers), -1, np.int64)
    everywhere[is_known] = indices
    return _factor(name, (labels, list(at)), everywhere, columns, is_number=True)


def _of_names(name: str, values: Sequence[Any], columns: SweepColumns) -> Factor:
    names: dict[str, int] = {}
    indices = np.array(
        [-1 if value is None else names.setdefault(_label(value), len(names)) for value in values],
        np.int64,
    )
    made = _factor(name, (list(names), list(range(len(names)))), indices, columns, is_number=False)
    if len(made.levels) <= MOST_NAMES:
        return made
    worst = sorted(made.levels, key=lambda level: (level.rate, level.label))[:MOST_NAMES]
    return Factor(name, is_number=False, levels=tuple(worst), indices=indices, is_cut=True)


def _factor(
    name: str,
    levels: tuple[list[str], list[Any]],
    indices: Counts,
    columns: SweepColumns,
    *,
    is_number: bool,
) -> Factor:
    """Count the rows of each level, and omit ranges without any."""
    labels, at = levels
    is_known = indices >= 0
    total = np.bincount(indices[is_known], minlength=len(labels))
    good = np.bincount(indices[is_known & columns.passed], minlength=len(labels))
    distinct = _distinct(indices, columns.samples, len(labels))
    kept = np.flatnonzero(total)
    renumbered = np.full(len(labels) + 1, -1, np.int64)
    renumbered[kept] = np.arange(len(kept))
    kept_levels = tuple(
        Level(labels[n], float(at[n]), int(good[n]), int(total[n]), int(distinct[n])) for n in kept
    )
    return Factor(name, is_number, kept_levels, renumbered[indices])


def _distinct(indices: Counts, samples: Counts, count: int) -> Counts:
    """Count the samples at each index from 0 to below `count`."""
    pairs = np.unique(np.stack([indices, samples])[:, indices >= 0], axis=1)
    return np.bincount(pairs[0], minlength=count)


@dataclass(frozen=True)
class Pair:
    """Two parameters, and the results of the runs at each pair of levels.

    Attributes:
        passed: Rows are levels of the second, columns of the first.
        total: The same for all runs.
        samples: The same for the distinct runs.
    """

    first: Factor
    second: Factor
    passed: Counts
    total: Counts
    samples: Counts

    @property
    def spread(self) -> float:
        """The difference of the success between cells beyond that of each parameter."""
        is_known = self.total > 0
        weights = self.total[is_known]
        rates = self.passed[is_known] / weights
        whole = float(
            np.average((rates - np.average(rates, weights=weights)) ** 2, weights=weights)
        )
        return whole - max(self.first.spread, self.second.spread)


def factors_of(columns: SweepColumns) -> list[Factor]:
    """Return what was varied, for curves and bars, without factors of a single level."""
    made = (factor(name, values, columns) for name, values in columns.values.items())
    return [known for known in made if len(known.levels) > 1]


def pairs_of(columns: SweepColumns, most: int = MOST_MAPS) -> tuple[list[Pair], int]:
    """Return the most informative pairs of parameters, and the number of omitted ones."""
    made = [factor(name, values, columns, MOST_CELLS) for name, values in columns.values.items()]
    shown = [known for known in made if len(known.levels) > 1 and not known.is_cut]
    pairs = [_pair(first, second, columns) for first, second in combinations(shown, 2)]
    pairs.sort(key=lambda pair: -round(pair.spread, 9))
    return pairs[:most], max(0, len(pairs) - most)


def _pair(first: Factor, second: Factor, columns: SweepColumns) -> Pair:
    shape = (len(second.levels), len(first.levels))
    is_known = (first.indices >= 0) & (second.indices >= 0)
    cells = second.indices * shape[1] + first.indices
    size = shape[0] * shape[1]
    total = np.bincount(cells[is_known], minlength=size)
    good = np.bincount(cells[is_known & columns.passed], minlength=size)
    samples = _distinct(np.where(is_known, cells, -1), columns.samples, size)
    made = (counts.reshape(shape) for counts in (good, total, samples))
    return Pair(first, second, *made)


def round_edges(low: float, high: float, most: int) -> Floats:
    """Return the ends of at most `most` equal ranges that cover `low` to `high`.

    They are multiples of 1, 2, 2.5 or 5 times a power of ten, so 0 is one of them.
    """
    if low == high:
        low, high = low - 0.5, high + 0.5
    least = (high - low) / most
    scale = 10.0 ** math.floor(math.log10(least))
    for factor_ in (1, 2, 2.5, 5, 10, 20):
        step = factor_ * scale
        first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
        if last - first <= most:
            break
    return np.arange(first, last + 1, dtype=np.float64) * step


def short(value: float) -> str:
    """A number with five digits at most."""
    return f"{value:.5g}"


def _label(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
