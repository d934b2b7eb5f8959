"""What scenarios differ in: parameters, and the values that each may have."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from bt_mission.core.diagnostics import Diagnostic, InputError, quoted
from bt_mission.core.yaml.document import read_text
from bt_mission.language.expressions.values import Plain

VARY_OPTION = "--vary"
PLACES = ("world", "robot", "start.x", "start.y", "start.yaw")
"""Parameters of the place of a run; others are inputs of the mission."""

_COLON = re.compile(r"([+-]?[\d.]+):([+-]?[\d.]+)")
EXAMPLES = "'speed=0.1,0.2' or 'speed=0.1..0.26'"
NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_INTERVAL = re.compile(rf"\s*({NUMBER})\s*\.\.\s*({NUMBER})\s*")
_DIGITS = 6


@dataclass(frozen=True)
class Choices:
    """A parameter that has one of several values.

    Attributes:
        name: ``world``, ``robot``, ``start.x``, ``start.y``, ``start.yaw``, or an input.
        values: As YAML reads them.
    """

    name: str
    values: tuple[Plain, ...]

    def at(self, share: float) -> Plain:
        """The value at a share from 0 to below 1 of the way through."""
        return self.values[min(int(share * len(self.values)), len(self.values) - 1)]

    @property
    def ends(self) -> tuple[Plain, ...]:
        """Values that must be possible, so that all are."""
        return self.values

    def __str__(self) -> str:
        return f"{self.name}={','.join(map(str, self.values))}"


@dataclass(frozen=True)
class Interval:
    """A parameter that has any value between two, both included.

    Attributes:
        name: As of :class:`Choices`.
        low: In the parameter's unit, as `high`.
        is_whole: Only whole numbers.
    """

    name: str
    low: float
    high: float
    is_whole: bool = False

    def at(self, share: float) -> Plain:
        """The value at a share from 0 to below 1 of the way, of six digits."""
        if self.is_whole:
            low, high = int(self.low), int(self.high)
            return min(low + int(share * (high - low + 1)), high)
        value = self.low + share * (self.high - self.low)
        return min(max(float(f"{value:.{_DIGITS}g}"), self.low), self.high)

    @property
    def ends(self) -> tuple[Plain, ...]:
        """Values that must be possible, so that all are."""
        return (self.at(0.0), self.at(1.0))

    def __str__(self) -> str:
        return f"{self.name}={self.low:g}..{self.high:g}"


Parameter: TypeAlias = Choices | Interval


def parse_parameter(text: str, option: str = VARY_OPTION) -> Parameter:
    """Read a parameter as the command line has it, such as ``speed=0.1,0.2`` or ``speed=0.1..0.3``.

    Values are those of a YAML list without its brackets. An interval between two integers holds
    whole numbers only.

    Raises:
        InputError: With what is wrong with it.
    """
    name, equals, written = text.partition("=")
    name = name.strip()
    if not equals or not name:
        raise _wrong(text, f"expected NAME=VALUES, such as {EXAMPLES}", option)
    if found := _INTERVAL.fullmatch(written):
        is_whole = all(re.fullmatch(r"[+-]?\d+", one) for one in found.groups())
        made = Interval(name, float(found[1]), float(found[2]), is_whole)
        return _checked(made, text, option)
    if colon := _COLON.fullmatch(written.strip()):
        instead = f"write '{name}={colon[1]}..{colon[2]}'"
        raise _wrong(text, f"expected values as in {EXAMPLES}; {instead}", option)
    try:
        values = read_text(f"[{written}]").data
    except InputError:
        values = None
    if not isinstance(values, list):
        raise _wrong(text, f"expected values as in {EXAMPLES}", option)
    return choices(name, values, text, option)


def read_parameters(written: Mapping[str, Any], file: str) -> tuple[Parameter, ...]:
    """Read parameters from a mapping: an interval is a text such as ``0.1..0.3``, else a list.

    Raises:
        InputError: With what is wrong.
    """
    found: list[Parameter] = []
    for name, values in written.items():
        if isinstance(values, Sequence) and not isinstance(values, str):
            found.append(choices(str(name), list(values), f"{name}: {values}", file))
        else:
            found.append(parse_parameter(f"{name}={values}", file))
    return tuple(found)


def choices(name: str, values: Sequence[Any], source: str, option: str) -> Choices:
    """Return a parameter with these values. Raises InputError where they are none, or repeated."""
    if not values or any(one is None or isinstance(one, dict) for one in values):
        raise _wrong(source, f"{quoted(name)}: expected values as in {EXAMPLES}", option)
    for number, value in enumerate(values):
        if value in values[:number] and type(value) is type(values[values.index(value)]):
            raise _wrong(source, f"{quoted(name)}: the value {value} stands there twice", option)
    return Choices(name, tuple(values))


def refuse_repeated(parameters: Sequence[Parameter], option: str = VARY_OPTION) -> None:
    """Refuse parameters that are given twice.

    Raises:
        InputError: With the first such name.
    """
    names = [one.name for one in parameters]
    for one in names:
        if names.count(one) > 1:
            raise _wrong(one, f"{quoted(one)} is given twice", option)


def _checked(one: Interval, source: str, option: str) -> Interval:
    if not one.low < one.high:
        message = f"{quoted(one.name)}: expected the lower end first, got {one.low:g}..{one.high:g}"
        raise _wrong(source, message, option)
    if one.name in ("world", "robot"):
        raise _wrong(source, f"{quoted(one.name)} has names, not numbers between two ends", option)
    return one


def _wrong(source: str, message: str, option: str) -> InputError:
    return InputError([Diagnostic(message, option, 1, 1, source)])
