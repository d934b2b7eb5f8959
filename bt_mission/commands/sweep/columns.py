"""The rows of a sweep as arrays, so that a hundred thousand take little memory."""

from __future__ import annotations

import math
from array import array
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from bt_mission.base.verdicts import VACUOUS
from bt_mission.commands.sweep.store import ResultStore
from bt_mission.commands.sweep.summary import SweepTally, sample_of
from bt_mission.scenarios.cause import Cause
from bt_mission.scenarios.concrete.row import ScenarioRow

Floats: TypeAlias = npt.NDArray[np.float64]
Flags: TypeAlias = npt.NDArray[np.bool_]
Counts: TypeAlias = npt.NDArray[np.int64]

NATURE = "nature."
"""Begins the names of nature's quantities among the parameters."""

PLAN = "plan of faults"
"""The name of the plans of faults among the parameters."""

WORST = 20


class SweepColumns:
    """All rows, by column; derived data is computed at its first use.

    Attributes:
        tally: Their totals.
        values: Of each parameter, a value for each row; None where a row has none. Plans of faults
            and what nature has drawn are parameters, too.
        causes: Why each row has not passed; None for one that has.
        coverage: The number of each bitmap of coverage.
        versions: The fingerprints of the versions that the rows were made with.
    """

    def __init__(self, rows: Iterable[ScenarioRow]) -> None:
        self.tally = SweepTally()
        self.values: dict[str, list[Any]] = {}
        self.causes: list[Cause | None] = []
        self.coverage: Counter[str] = Counter()
        self.versions: Counter[str] = Counter()
        self._ids: list[tuple[int, str]] = []
        self._passed = bytearray()
        self._is_error = bytearray()
        self._seconds = array("d")
        self._samples = array("Q")
        self._margins: dict[str, array[float]] = defaultdict(lambda: array("d"))
        known_causes: dict[Cause | None, Cause | None] = {}
        for row in rows:
            self._add(row)
            self.causes.append(known_causes.setdefault(row.cause, row.cause))
        for column in self.values.values():
            column.extend([None] * (len(self) - len(column)))

    def _add(self, row: ScenarioRow) -> None:
        self.tally.add(row)
        values = {**row.parameters, **({PLAN: row.plan} if row.plan else {})}
        values |= {f"{NATURE}{name}": value for name, value in row.nature.items()}
        for name, value in values.items():
            column = self.values.setdefault(name, [])
            column.extend([None] * (len(self) - len(column)))
            column.append(value)
        for name, margin in _margins_of(row):
            margins = self._margins[name]
            margins.extend([math.nan] * (len(self) - len(margins)))
            margins.append(margin)
        self._ids.append((row.number, row.id))
        self._passed.append(row.passed)
        self._is_error.append(row.is_error)
        self._seconds.append(row.virtual_s)
        self._samples.append(sample_of(row))
        self.coverage[row.coverage] += 1
        self.versions[row.versions] += 1

    def __len__(self) -> int:
        return len(self._ids)

    @cached_property
    def passed(self) -> Flags:
        """Whether each passed."""
        return np.frombuffer(self._passed, np.uint8).astype(bool)

    @cached_property
    def samples(self) -> Counts:
        """The number of the sample of each; runs that count as one have the same."""
        numbers = np.frombuffer(self._samples, np.uint64)
        return np.unique(numbers, return_inverse=True)[1].astype(np.int64)

    @cached_property
    def ran(self) -> Flags:
        """Whether each could run."""
        return ~np.frombuffer(self._is_error, np.uint8).astype(bool)

    @cached_property
    def seconds(self) -> Floats:
        """The duration of the mission of each, s of its own time."""
        return np.frombuffer(self._seconds, np.float64)

    def margins(self, name: str) -> Floats:
        """Return the margins of a requirement; NaN for a run without one."""
        margins = np.full(len(self), np.nan)
        known = np.frombuffer(self._margins.get(name, b""), np.float64)
        margins[: len(known)] = known
        return margins

    # ---- the worst -----------------------------------------------------------------------

    @cached_property
    def _scales(self) -> dict[str, float]:
        """The mean size of each requirement's margin, so that metres and seconds compare.

        A requirement with the same margin in every run is omitted.
        """
        known = {name: np.array(margins) for name, margins in self._margins.items()}
        return {
            name: float(np.nanmean(np.abs(margins)))
            for name, margins in known.items()
            if np.nanmin(margins) < np.nanmax(margins)
        }

    def worst(self, most: int = WORST) -> list[str]:
        """Return the ids of the worst rows, the worst first.

        Failed ones are first: of each cause the one with the smallest margin, then the second of
        each, and so on. Then follow those that passed, with the smallest margins first. A margin
        counts as a multiple of the requirement's mean one. Scenarios that could not run are
        omitted.
        """
        least = np.full(len(self), np.inf)
        for name, scale in self._scales.items():
            least = np.fmin(least, self.margins(name) / scale)
        turns: Counter[Cause | None] = Counter()
        order = []
        for row in sorted(
            np.flatnonzero(self.ran), key=lambda row: (self.passed[row], least[row], self._ids[row])
        ):
            cause = self.causes[row]
            order.append((cause is None, turns[cause], least[row], self._ids[row]))
            turns[cause] += cause is not None
        return [id_ for *_, (_, id_) in sorted(order)[:most]]

    def worst_rows(self, store: ResultStore, most: int = WORST) -> list[ScenarioRow]:
        """Return the worst rows of the results that these are, the worst first."""
        return [
            row for scenario_id in self.worst(most) for row in store.rows("id = ?", scenario_id)
        ]

    def nearest(self, row: ScenarioRow) -> str | None:
        """Return the requirement whose margin ranks a row; None without one."""
        shares = [
            (margin / self._scales[name], name)
            for name, margin in _margins_of(row)
            if name in self._scales
        ]
        return min(shares)[1] if shares else None


def _margins_of(row: ScenarioRow) -> Iterator[tuple[str, float]]:
    """Yield the name and the margin of each requirement that was exercised, if it is finite."""
    for name, requirement in row.requirements.items():
        if requirement.verdict in VACUOUS:
            continue
        if requirement.margin is not None and math.isfinite(requirement.margin):
            yield name, requirement.margin
