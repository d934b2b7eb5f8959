"""Units behind numbers, in missions, requirements and faults."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeAlias

from bt_mission.base.diagnostics import did_you_mean

Dimension: TypeAlias = tuple[int, int, int]
"""Powers of metres, seconds and radians."""

METRES: Dimension = (1, 0, 0)
SECONDS: Dimension = (0, 1, 0)
RADIANS: Dimension = (0, 0, 1)

_DEG = math.pi / 180

UNITS: Mapping[str, tuple[float, str]] = {
    "s": (1.0, "s"),
    "ms": (1e-3, "s"),
    "min": (60.0, "s"),
    "m": (1.0, "m"),
    "cm": (1e-2, "m"),
    "mm": (1e-3, "m"),
    "m/s": (1.0, "m/s"),
    "cm/s": (1e-2, "m/s"),
    "mm/s": (1e-3, "m/s"),
    "rad": (1.0, "rad"),
    "deg": (_DEG, "rad"),
    "rad/s": (1.0, "rad/s"),
    "deg/s": (_DEG, "rad/s"),
    "N": (1.0, "N"),
    "Nm": (1.0, "Nm"),
}
"""Each unit with its size in its base unit."""

DIMENSIONS: Mapping[str, Dimension] = {
    "m": METRES,
    "s": SECONDS,
    "rad": RADIANS,
    "m/s": (1, -1, 0),
    "rad/s": (0, -1, 1),
}
"""The base units that expressions and requirements compute with."""

COMPUTED: Mapping[str, Dimension] = {
    name: DIMENSIONS[base] for name, (_, base) in UNITS.items() if base in DIMENSIONS
}
"""The units of expressions and requirements."""

WORDS: Mapping[str, str] = {
    "meters": "m",
    "metres": "m",
    "meter": "m",
    "metre": "m",
    "meters per second": "m/s",
    "metres per second": "m/s",
    "m/sec": "m/s",
    "seconds": "s",
    "second": "s",
    "sec": "s",
    "milliseconds": "ms",
    "minutes": "min",
    "minute": "min",
    "radians": "rad",
    "radians per second": "rad/s",
    "rad/sec": "rad/s",
    "degrees": "deg",
    "degree": "deg",
}
"""Words for units, with the units."""


def in_base(number: float, unit: str) -> float:
    """Return a number of a unit in the base unit: 57 cm are 0.57 m, to the last digit."""
    size = UNITS[unit][0]
    # A division by 100 is rounded once; 0.01 is already rounded.
    return number / round(1 / size) if size in (1e-2, 1e-3) else number * size


def converted(number: float, unit: str, wanted: str) -> float:
    """Return a number of one unit in another one of the same base unit."""
    return number if unit == wanted else in_base(number, unit) / UNITS[wanted][0]


def near_unit(written: str) -> str | None:
    """Return a hint at the unit of a word, or None."""
    word = WORDS.get(written.lower())
    plain = [unit for unit in COMPUTED if "/" not in unit]
    return f"write '{word}'" if word else did_you_mean(written, plain)


def shown_unit(unit: Dimension | None) -> str:
    """Return a unit in its usual form: ``m/s``; empty for a number without one."""
    names = ("m", "s", "rad")
    above = [_power(name, power) for name, power in zip(names, unit or (0, 0, 0), strict=True)]
    below = [_power(name, -power) for name, power in zip(names, unit or (0, 0, 0), strict=True)]
    over, under = " ".join(filter(None, above)), " ".join(filter(None, below))
    if not under:
        return over
    return f"{over or '1'}/{under}"


def _power(name: str, power: int) -> str:
    return "" if power < 1 else name if power == 1 else f"{name}^{power}"
