"""The factor that explains a cause of failures: one split of one factor, as a sentence."""

from __future__ import annotations

import json
import math
from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from bt_mission.base.nature import BY_NAME
from bt_mission.commands.sweep.columns import NATURE, PLAN, Counts, Flags, Floats, SweepColumns
from bt_mission.commands.sweep.summary import OutcomeCount
from bt_mission.scenarios.cause import Cause

SIGNIFICANT = 0.05
"""The greatest probability that such a split is random, over all that are tried together."""

FEWEST = 3
"""Runs of a cause, and other runs, from which on it is explained."""

MOST_VALUES = 200
"""Values of a parameter that are counted one by one."""

MOST_SPLITS = 200
"""Ends of a number that are tried."""


@dataclass(frozen=True)
class Explanation:
    """A split of a factor with most runs of a cause on one side, and few others.

    Attributes:
        what: Such as ``gap < 0.4``.
        share: The share of the cause's runs on that side.
        of_others: The share of all other runs there.
        chance: The probability that such a split is random, over all that were tried.
    """

    what: str
    share: float
    of_others: float
    chance: float

    def __str__(self) -> str:
        others = f"{100 * self.of_others:.0f} % of the other runs"
        return f"{100 * self.share:.0f} % of these have {self.what} ({others})"


@dataclass(frozen=True)
class _Splits:
    """All splits of one factor.

    Attributes:
        words: The text of each side of each split.
        bins: The bin of each row; -1 without a value.
        count: The number of bins.
        is_number: Whether each split is an end between two bins, with a side below and one above.
            Otherwise it is a single bin.
    """

    words: tuple[str, ...]
    bins: Counts
    count: int
    is_number: bool

    def sizes(self, rows: Flags) -> Counts:
        """Count the rows on each side, among some rows."""
        bins = self.bins[rows & (self.bins >= 0)]
        counts = np.bincount(bins, minlength=self.count)
        if not self.is_number:
            return counts
        below = np.cumsum(counts)[:-1]
        return np.concatenate([below, len(bins) - below])


class Explainer:
    """Explains causes by the factors of a sweep.

    The best split by information gain is taken, if Fisher's exact test, with Bonferroni's
    correction for all splits that were tried, finds it significant. Rows that are the same sample
    with the same factors count once.
    """

    def __init__(self, columns: SweepColumns) -> None:
        kept = _distinct(columns)
        self._causes = [columns.causes[row] for row in kept]
        made = (
            _splits(name, [values[row] for row in kept]) for name, values in columns.values.items()
        )
        self._factors = [factor for factor in made if factor is not None]
        self._words = [words for factor in self._factors for words in factor.words]
        self._sizes = self._count(np.ones(len(kept), bool))

    def explain(self, cause: Cause | None) -> Explanation | None:
        """Return the explanation of a cause; None without a significant factor."""
        of_cause = np.array([other == cause for other in self._causes], bool)
        total, count = len(of_cause), int(of_cause.sum())
        if cause is None or min(count, total - count) < FEWEST or not self._words:
            return None
        inside, sizes = self._count(of_cause), self._sizes
        is_more = inside * (total - count) > (sizes - inside) * count
        gains = np.where(is_more, _gains(inside, sizes, count, total), -1.0)
        best = int(np.argmax(gains))
        if gains[best] <= 0:
            return None
        here, size = int(inside[best]), int(sizes[best])
        table = [[here, count - here], [size - here, total - count - (size - here)]]
        # Takes a second to import, and only the page of a finished sweep needs it.
        from scipy.stats import fisher_exact

        chance = min(1.0, float(fisher_exact(table).pvalue) * len(self._words))
        if chance > SIGNIFICANT:
            return None
        others = (size - here) / (total - count)
        return Explanation(self._words[best], here / count, others, chance)

    def _count(self, rows: Flags) -> Counts:
        """Count the rows on each side of all splits, among some rows."""
        if not self._factors:
            return np.zeros(0, np.int64)
        return np.concatenate([factor.sizes(rows) for factor in self._factors])


def results_as_dict(columns: SweepColumns) -> dict[str, Any]:
    """Return what ``--json`` prints of a sweep: its totals, each failure with its explanation."""
    tally, explainer = columns.tally, Explainer(columns)
    failures = []
    for group in tally.failures:
        explanation = explainer.explain(group.cause)
        explained_by = None if explanation is None else str(explanation)
        failures.append({**group.as_dict(), "explained_by": explained_by})
    names = [key for key in columns.values if key != PLAN and not key.startswith(NATURE)]
    return {
        **tally.count.as_dict(),
        "orphaned_goals": tally.orphaned_goals,
        "collisions": tally.collisions,
        "virtual_s": round(tally.virtual_s, 3),
        "wall_s": round(tally.wall_s, 3),
        "distance_m": round(tally.distance_m, 3),
        "failures": failures,
        "parameters": {name: _by_value(columns, name) for name in names},
        "plans": {
            str(entry.pop("value")): entry
            for entry in (_by_value(columns, PLAN, None) if PLAN in columns.values else ())
        },
        "requirements": {
            name: requirement.as_dict() for name, requirement in tally.requirements.items()
        },
    }


def _by_value(
    columns: SweepColumns, name: str, most: int | None = MOST_VALUES
) -> list[dict[str, Any]]:
    """Count the outcomes of each value; with more than `most` values, of ranges of them."""
    rows: dict[str, list[int]] = {}
    for row, value in enumerate(columns.values[name]):
        if value is not None:
            rows.setdefault(json.dumps(value), []).append(row)
    groups = sorted(((json.loads(key), rows) for key, rows in rows.items()), key=_order)
    size = 1 if most is None else -(-len(groups) // most)
    parts = [groups[start : start + size] for start in range(0, len(groups), size)]
    return [
        {
            **({"value": part[0][0]} if size == 1 else {"from": part[0][0], "to": part[-1][0]}),
            **_outcomes(columns, [row for _, rows in part for row in rows]).as_dict(),
        }
        for part in parts
    ]


def _order(pair: tuple[Any, list[int]]) -> tuple[bool, float, str]:
    """Numbers by size, then all else by its text."""
    value = pair[0]
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return not is_number, float(value) if is_number else 0.0, str(value)


def _outcomes(columns: SweepColumns, rows: list[int]) -> OutcomeCount:
    passed, errors = int(columns.passed[rows].sum()), int((~columns.ran[rows]).sum())
    samples = set(columns.samples[rows].tolist())
    return OutcomeCount(passed, len(rows) - passed - errors, errors, known_samples=samples)


def _distinct(columns: SweepColumns) -> list[int]:
    """Return the first row of each sample with the same factors."""
    seen: set[Hashable] = set()
    kept = []
    samples = columns.samples
    for row in range(len(columns)):
        key = (int(samples[row]), *(str(values[row]) for values in columns.values.values()))
        if key not in seen:
            seen.add(key)
            kept.append(row)
    return kept


def _splits(name: str, values: list[Any]) -> _Splits | None:
    """Return the splits of a factor; None for a single value."""
    shown = name.removeprefix(NATURE)
    known = [value for value in values if value is not None]
    if known and all(
        isinstance(value, int | float) and not isinstance(value, bool) for value in known
    ):
        unit = BY_NAME[shown].unit if name != shown and shown in BY_NAME else ""
        numbers = np.array([math.nan if value is None else value for value in values], np.float64)
        ends = list(_ends(numbers))
        bins = np.searchsorted(ends, numbers, side="right").astype(np.int64)
        bins[~np.isfinite(numbers)] = -1
        words = [
            f"{shown} {sign} {end:.12g} {unit}".rstrip() for sign in ("<", ">=") for end in ends
        ]
        return _Splits(tuple(words), bins, len(ends) + 1, is_number=True) if ends else None
    places: dict[str, int] = {}
    indices = [
        -1 if value is None else places.setdefault(str(value), len(places)) for value in values
    ]
    words = [f"{shown} = {place}" for place in places]
    if len(words) < 2:
        return None
    return _Splits(tuple(words), np.array(indices, np.int64), len(words), is_number=False)


def _ends(numbers: Floats) -> Iterator[float]:
    """Yield at most `MOST_SPLITS` short numbers between neighbours, spread over the values."""
    distinct = np.unique(numbers[np.isfinite(numbers)])
    count = len(distinct) - 1
    for place in np.unique(np.linspace(0, count - 1, min(count, MOST_SPLITS)).astype(int)):
        yield short_between(float(distinct[place]), float(distinct[place + 1]))


def short_between(low: float, high: float) -> float:
    """Return a number above `low` and up to `high` with few digits."""
    for digits in range(1, 17):
        middle = float(f"{(low + high) / 2:.{digits}g}")
        if low < middle <= high:
            return middle
    return high


def _gains(inside: Any, sizes: Any, count: int, total: int) -> Any:
    """Return the information gain of splits, in bits.

    Args:
        inside: Runs of the cause on the side of each.
        sizes: All runs there.
        count: Runs of the cause.
        total: All runs.
    """
    outside = total - sizes
    within = sizes * _entropy(inside, sizes) + outside * _entropy(count - inside, outside)
    return _entropy(np.array(count), np.array(total)) - within / total


def _entropy(part: Any, whole: Any) -> Any:
    share = part / np.maximum(whole, 1)
    logarithms = [np.log2(np.where(fraction > 0, fraction, 1.0)) for fraction in (share, 1 - share)]
    return -(share * logarithms[0] + (1 - share) * logarithms[1])
