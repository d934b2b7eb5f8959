"""The worst runs of a sweep: those that are worth a look."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

from bt_mission.scenarios.cause import Cause
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.store import ResultStore

WORST = 20


@dataclass
class MarginScale:
    """How large the margins of a requirement are, so that metres and seconds can be compared."""

    least: float = math.inf
    most: float = -math.inf
    total: float = 0.0
    count: int = 0

    def add(self, margin: float) -> None:
        """Count a margin."""
        self.least, self.most = min(self.least, margin), max(self.most, margin)
        self.total += abs(margin)
        self.count += 1

    def share(self, margin: float) -> float:
        """A margin as a multiple of the mean; infinite where all runs have the same."""
        if self.least == self.most or not self.total:
            return math.inf
        return margin * self.count / self.total


def margins_of(row: ScenarioRow) -> Iterator[tuple[str, float]]:
    """Yield the name and the margin of each requirement that has one."""
    for name, one in row.requirements.items():
        if one.margin is not None and math.isfinite(one.margin):
            yield name, one.margin


_Ranked: TypeAlias = tuple[int, str, bool, int, tuple[tuple[str, float], ...]]
"""Number, id, has it passed, number of its cause, margins by requirement."""


class WorstRows:
    """Finds the worst rows; rows are added one by one, and only ids are kept.

    Failed ones come first: of each cause the one with the smallest margin, then the second of each,
    and so on. Then come those that have passed, with the smallest margins first. A margin counts as
    a multiple of the requirement's mean one. What could not run has no margin and is left out.
    """

    def __init__(self) -> None:
        self._scales: dict[str, MarginScale] = defaultdict(MarginScale)
        self._rows: list[_Ranked] = []
        self._causes: dict[Cause | None, int] = {}

    def add(self, row: ScenarioRow) -> None:
        """Add a row."""
        if row.is_error:
            return
        margins = tuple(margins_of(row))
        for name, margin in margins:
            self._scales[name].add(margin)
        cause = -1 if row.passed else self._causes.setdefault(row.cause, len(self._causes))
        self._rows.append((row.number, row.id, row.passed, cause, margins))

    def ids(self, most: int = WORST) -> list[str]:
        """Return the ids of the worst, the worst first."""
        ranked = sorted(
            (passed, self._least(margins), number, cause, id_)
            for number, id_, passed, cause, margins in self._rows
        )
        turns: dict[int, int] = defaultdict(int)
        order = []
        for passed, least, number, cause, id_ in ranked:
            turn = 0 if passed else turns[cause]
            turns[cause] += 1
            order.append((passed, turn, least, number, id_))
        return [id_ for *_, id_ in sorted(order)[:most]]

    def nearest(self, row: ScenarioRow) -> str | None:
        """Name the requirement by whose margin a row counts; None where it has none."""
        shares = [(self._scales[name].share(one), name) for name, one in margins_of(row)]
        least, name = min(shares, default=(math.inf, ""))
        return name if least < math.inf else None

    def _least(self, margins: Iterable[tuple[str, float]]) -> float:
        return min((self._scales[name].share(one) for name, one in margins), default=math.inf)


def worst_rows(store: ResultStore, most: int = WORST) -> list[ScenarioRow]:
    """Return the worst rows of results, the worst first."""
    found = WorstRows()
    for row in store.rows():
        found.add(row)
    return rows_of(store, found.ids(most))


def rows_of(store: ResultStore, ids: list[str]) -> list[ScenarioRow]:
    """Return the rows of ids, in their order."""
    return [row for one in ids for row in store.rows("id = ?", one)]
