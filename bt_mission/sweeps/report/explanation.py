"""The factor that explains a cause of failures: one split of one factor, in a sentence."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import fisher_exact

from bt_mission.core.nature import BY_NAME
from bt_mission.scenarios.cause import Cause
from bt_mission.sweeps.report.columns import NATURE, Counts, Flags, Floats, SweepColumns

SIGNIFICANT = 0.05
"""The greatest probability that chance gives such a split, of all that are tried together."""

FEWEST = 3
"""Runs of a cause, and other runs, from which on it is explained."""

MOST_SPLITS = 200
"""Ends of a number that are tried."""


@dataclass(frozen=True)
class Explanation:
    """A split of a factor that most runs of a cause are on one side of, and few others.

    Attributes:
        what: Such as ``gap < 0.4``.
        share: Of the runs of the cause on that side.
        of_others: Share of all other runs there.
        chance: The probability that chance gives such a split, of all that were tried.
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
        words: Of each side of each split.
        bins: Where the value of each row lies; -1 where it has none.
        count: How many bins there are.
        is_number: Is each split an end between two bins, with a side below and one above? Else it
            is a bin alone.
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
    correction for all splits that were tried, says that it is not chance. Rows that are the same
    sample with the same factors count once.
    """

    def __init__(self, columns: SweepColumns) -> None:
        kept = _distinct(columns)
        self._causes = [columns.causes[row] for row in kept]
        made = (
            _splits(name, [values[row] for row in kept]) for name, values in columns.values.items()
        )
        self._factors = [one for one in made if one is not None]
        self._words = [words for one in self._factors for words in one.words]
        self._sizes = self._count(np.ones(len(kept), bool))

    def explain(self, cause: Cause | None) -> Explanation | None:
        """Return what explains a cause; None where no factor does significantly."""
        of_cause = np.array([one == cause for one in self._causes], bool)
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
        chance = min(1.0, float(fisher_exact(table).pvalue) * len(self._words))
        if chance > SIGNIFICANT:
            return None
        others = (size - here) / (total - count)
        return Explanation(self._words[best], here / count, others, chance)

    def _count(self, rows: Flags) -> Counts:
        """Count the rows on each side of all splits, among some rows."""
        if not self._factors:
            return np.zeros(0, np.int64)
        return np.concatenate([one.sizes(rows) for one in self._factors])


def results_as_dict(columns: SweepColumns) -> dict[str, Any]:
    """Return what ``--json`` prints of a sweep: its totals, each failure with its explanation."""
    found = columns.tally.as_dict()
    explainer = Explainer(columns)
    for group, written in zip(columns.tally.failures, found["failures"], strict=True):
        explanation = explainer.explain(group.cause)
        written["explained_by"] = None if explanation is None else str(explanation)
    return found


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
    """Return the splits of a factor; None where it has one value only."""
    shown = name.removeprefix(NATURE)
    known = [one for one in values if one is not None]
    if known and all(isinstance(one, int | float) and not isinstance(one, bool) for one in known):
        unit = BY_NAME[shown].unit if name != shown and shown in BY_NAME else ""
        numbers = np.array([math.nan if one is None else one for one in values], np.float64)
        ends = list(_ends(numbers))
        bins = np.searchsorted(ends, numbers, side="right").astype(np.int64)
        bins[~np.isfinite(numbers)] = -1
        words = [
            f"{shown} {sign} {end:.12g} {unit}".rstrip() for sign in ("<", ">=") for end in ends
        ]
        return _Splits(tuple(words), bins, len(ends) + 1, is_number=True) if ends else None
    places: dict[str, int] = {}
    found = [-1 if one is None else places.setdefault(str(one), len(places)) for one in values]
    words = [f"{shown} = {one}" for one in places]
    if len(words) < 2:
        return None
    return _Splits(tuple(words), np.array(found, np.int64), len(words), is_number=False)


def _ends(numbers: Floats) -> Iterator[float]:
    """Yield short numbers between neighbours, at most so many, evenly spread over the values."""
    distinct = np.unique(numbers[np.isfinite(numbers)])
    count = len(distinct) - 1
    for place in np.unique(np.linspace(0, count - 1, min(count, MOST_SPLITS)).astype(int)):
        yield short_between(float(distinct[place]), float(distinct[place + 1]))


def short_between(low: float, high: float) -> float:
    """Return a number above `low` and up to `high` with few digits."""
    for digits in range(1, 17):
        found = float(f"{(low + high) / 2:.{digits}g}")
        if low < found <= high:
            return found
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
    logarithms = [np.log2(np.where(one > 0, one, 1.0)) for one in (share, 1 - share)]
    return -(share * logarithms[0] + (1 - share) * logarithms[1])
