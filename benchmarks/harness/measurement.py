"""What a benchmark has given: the values of each figure, of one commit or of two."""

from __future__ import annotations

import json
import statistics
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.harness.benchmark import Aim, Benchmark, Target


@dataclass(frozen=True)
class Spread:
    """Median, least and most of some values."""

    median: float
    least: float
    most: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Spread:
        """Summarise values, of which there is at least one."""
        return cls(statistics.median(values), min(values), max(values))

    def text(self, unit: str = "") -> str:
        """As it stands in tables: ``34 ms (33 to 38)``."""
        median, least, most = map(_digits, (self.median, self.least, self.most))
        name = f"{median} {unit}" if unit else median
        return name if least == most else f"{name} ({least} to {most})"


def _digits(value: float) -> str:
    """Three digits that say something, without an exponent."""
    if value == 0:
        return "0"
    if abs(value) >= 100:
        return f"{value:.0f}"
    return f"{value:.{2 if abs(value) >= 1 else 3}f}"


@dataclass
class Values:
    """The values of one figure: `new` and `old` are round by round.

    Args:
        name: Of the figure.
        unit: Of the values.
    """

    name: str
    unit: str
    new: list[float] = field(default_factory=list)
    old: list[float] = field(default_factory=list)
    ratios: list[float] = field(default_factory=list)
    """New to old, of rounds in which both were measured, one after the other."""

    def is_met(self, target: Target | None) -> bool | None:
        """Whether the target is reached; None where there is none, or nothing to judge by."""
        if target is None:
            return None
        values = self.ratios if target.kind is Aim.OF_OLD else self.new
        return target.is_met(statistics.median(values)) if values else None


@dataclass
class Measurement:
    """What became of a benchmark.

    Args:
        benchmark: Which.
        figures: By name, in the order in which they came.
        seconds: How long it took.
        failures: Why it has failed, in words, with the end of its output; empty where all is well.
        old_lacks: Why the other commit has no figures; empty where it has.
        old_script: Whether the other commit was measured by its own script.
    """

    benchmark: Benchmark
    figures: dict[str, Values] = field(default_factory=dict)
    seconds: float = 0.0
    failures: list[str] = field(default_factory=list)
    old_lacks: str = ""
    old_script: bool = False

    def add(self, new: dict[str, Given], old: dict[str, Given] | None = None) -> None:
        """Add what a round has given; `old` is of the other commit, measured beside it."""
        for name, one in {**new, **{n: o for n, o in (old or {}).items() if n not in new}}.items():
            values = self.figures.setdefault(name, Values(name, one.unit))
            here = new[name].values if name in new else []
            there = old[name].values if old and name in old else []
            values.new += here
            values.old += there
            if here and there and statistics.median(there):
                values.ratios.append(statistics.median(here) / statistics.median(there))


@dataclass
class Given:
    """The values of a figure that one round has given."""

    unit: str
    values: list[float]


class WrongCodeError(Exception):
    """A process has measured another copy of the software than it was to."""


def read_figures(path: Path, code: Path) -> dict[str, Given]:
    """Read what the processes of a round have given.

    Args:
        path: The file that they wrote to.
        code: The tree whose software was to be measured.

    Raises:
        WrongCodeError: Where they imported another one.
    """
    found: dict[str, Given] = {}
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    for line in lines:
        record: dict[str, Any] = json.loads(line)
        wanted = code / "bt_mission"
        if Path(record["code"]) != wanted:
            raise WrongCodeError(
                f"it was to measure {wanted}, but imported {record['code'] or 'none'}: "
                "this Python has another copy installed; use the environment of this checkout"
            )
        one = found.setdefault(record["figure"], Given(record["unit"], []))
        one.values += record["values"]
    return found
