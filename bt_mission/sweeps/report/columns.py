"""What the page needs of every row, as arrays: a hundred thousand rows take little memory so."""

from __future__ import annotations

import math
from array import array
from collections import Counter, defaultdict
from collections.abc import Iterable
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from bt_mission.scenarios.cause import Cause
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.summary import SweepTally, sample_of
from bt_mission.sweeps.worst import WorstRows, margins_of

Floats: TypeAlias = npt.NDArray[np.float64]
Flags: TypeAlias = npt.NDArray[np.bool_]
Counts: TypeAlias = npt.NDArray[np.int64]

NATURE = "nature."
"""Begins the names of nature's quantities among the parameters."""

PLAN = "plan of faults"
"""What the plans of faults are called among the parameters."""


class SweepColumns:
    """All rows, column by column.

    Attributes:
        tally: What they come to.
        worst: Finds the worst of them.
        values: Of each parameter, a value for each row; None where a row has none. Plans of faults
            and what nature has drawn are parameters, too.
        causes: Why each row has not passed; None for one that has.
        coverage: How often each bitmap of coverage came out.
        versions: The fingerprints of the versions that the rows were made with.
    """

    def __init__(self) -> None:
        self.tally = SweepTally()
        self.worst = WorstRows()
        self.values: dict[str, list[Any]] = {}
        self.causes: list[Cause | None] = []
        self.coverage: Counter[str] = Counter()
        self.versions: Counter[str] = Counter()
        self._count = 0
        self._passed = bytearray()
        self._is_error = bytearray()
        self._seconds = array("d")
        self._known_causes: dict[Cause | None, Cause | None] = {}
        self._samples = array("Q")
        self._margins: dict[str, array[float]] = defaultdict(lambda: array("d"))

    @classmethod
    def of(cls, rows: Iterable[ScenarioRow]) -> SweepColumns:
        """Read all rows."""
        columns = cls()
        for row in rows:
            columns.add(row)
        return columns

    def add(self, row: ScenarioRow) -> None:
        """Add a row."""
        self.tally.add(row)
        self.worst.add(row)
        values = {**row.parameters, **({PLAN: row.plan} if row.plan else {})}
        values |= {f"{NATURE}{name}": value for name, value in row.nature.items()}
        for name, value in values.items():
            if name not in self.values:
                self.values[name] = [None] * self._count
            self.values[name].append(value)
        for name, margin in margins_of(row):
            column = self._margins[name]
            if len(column) < self._count:
                column.extend([math.nan] * (self._count - len(column)))
            column.append(margin)
        self._passed.append(row.passed)
        self._is_error.append(row.is_error)
        self._seconds.append(row.virtual_s)
        self._samples.append(sample_of(row))
        cause = row.cause
        self.causes.append(self._known_causes.setdefault(cause, cause))
        self.coverage[row.coverage] += 1
        self.versions[row.versions] += 1
        self._count += 1
        for column_of_values in self.values.values():
            if len(column_of_values) < self._count:
                column_of_values.append(None)

    def __len__(self) -> int:
        return self._count

    @property
    def passed(self) -> Flags:
        """Did each pass?"""
        return np.frombuffer(self._passed, np.uint8).astype(bool)

    @property
    def samples(self) -> Counts:
        """The number of the sample of each: equal for runs that count as one."""
        numbers = np.frombuffer(self._samples, np.uint64)
        return np.unique(numbers, return_inverse=True)[1].astype(np.int64)

    @property
    def ran(self) -> Flags:
        """Could each run?"""
        return ~np.frombuffer(self._is_error, np.uint8).astype(bool)

    @property
    def seconds(self) -> Floats:
        """How long the mission of each took, s of its own time."""
        return np.frombuffer(self._seconds, np.float64)

    def margins(self, name: str) -> Floats:
        """The margins of a requirement; NaN where a run has none."""
        found = np.full(self._count, np.nan)
        if name in self._margins:
            known = np.frombuffer(self._margins[name], np.float64)
            found[: len(known)] = known
        return found
