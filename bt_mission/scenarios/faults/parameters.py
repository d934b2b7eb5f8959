"""What a fault takes: each parameter with its unit, its range, and how it is drawn at random."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from numbers import Real
from typing import Any, Literal, TypeAlias

from bt_mission.scenarios.draws import Draws, number, one_of
from bt_mission.scenarios.faults.drawable import Drawable

Form = Literal["number", "integer", "flag", "text", "numbers", "anything", "python"]
"""What is written for an argument; ``python`` is given by code alone."""

Thing = Literal["", "topic", "action", "service", "node", "leaf"]

Drawn: TypeAlias = Callable[[Draws, Drawable], Any]
"""Draws an argument."""

REQUIRED: Any = inspect.Parameter.empty


@dataclass(frozen=True)
class Range:
    """The numbers that an argument can be; ``is_open``: `low` itself is excluded."""

    low: float = -math.inf
    high: float = math.inf
    is_open: bool = False

    def __contains__(self, value: float) -> bool:
        return (self.low < value if self.is_open else self.low <= value) and value <= self.high

    def __str__(self) -> str:
        if self.is_open:
            return f"above {self.low:g}" + f" and at most {self.high:g}" * math.isfinite(self.high)
        if math.isinf(self.low):
            return ""
        if math.isinf(self.high):
            return f"from {self.low:g} up"
        return f"from {self.low:g} to {self.high:g}"


ANY = Range()
FROM_0 = Range(0)
ABOVE_0 = Range(0, is_open=True)
FROM_1 = Range(1)
FROM_2 = Range(2)
SHARE_RANGE = Range(0, 1, is_open=True)


@dataclass(frozen=True)
class Parameter:
    """One parameter of a fault.

    Attributes:
        form: What is written.
        text: What it is for; empty where the name says all.
        default: Of an argument that is left out; REQUIRED, and the fault cannot do without it.
        unit: Of a number, or of each of several.
        allowed: The numbers that it can be, in the unit.
        names: Of what in the graph a text is the name.
        choices: The texts that it can be; empty where any will do.
        count: How many numbers belong together.
        by_name: It is given with its name alone.
        repeats: It can be given several times, by position alone.
        is_quiet: The trace leaves the default out; so it does with one that is 0 or off.
        takes: What code may give instead of data.
        drawn: Draws it; None is the default.
    """

    name: str
    form: Form
    text: str = ""
    default: Any = REQUIRED
    unit: str = ""
    allowed: Range = ANY
    names: Thing = ""
    choices: tuple[str, ...] = ()
    count: int = 1
    by_name: bool = False
    repeats: bool = False
    is_quiet: bool = False
    takes: Any = ()
    drawn: Drawn | None = None

    @property
    def is_required(self) -> bool:
        """Tell whether the fault cannot do without it."""
        return self.default is REQUIRED and not self.repeats

    @property
    def usage(self) -> str:
        """How it is written: ``<by s>`` by position, ``[jitter s]`` by its name."""
        if self.form == "flag":
            return f"[{self.name} false]" if self.default else f"[{self.name}]"
        value = self.unit or ("N" if self.form in ("number", "integer") else self.name.upper())
        if self.choices:
            value = "|".join(f'"{name}"' if " " in name else name for name in self.choices)
        if self.form == "numbers":
            value = f"({', '.join([self.unit] * self.count)})"
        if self.by_name:
            written = f"{self.name} {value}"
        elif self.choices or self.form not in ("number", "integer"):
            written = value
        else:
            written = f"<{self.name} {self.unit}>" if self.unit else f"<{self.name}>"
        written = written if self.is_required else f"[{written}]"
        return f"{written}..." if self.repeats else written

    @property
    def expected(self) -> str:
        """The expected form of its value, as text."""
        where = (f" in {self.unit}" if self.unit else "") + f" {self.allowed}".rstrip()
        if self.choices:
            return f"one of {', '.join(self.choices)}"
        forms: dict[Form, str] = {
            "number": f"a number{where}",
            "integer": f"an integer{where}",
            "flag": "true or false",
            "text": f"the name of a {self.names}" if self.names else "a text",
            "numbers": f"{self.count} numbers{where}, such as ({', '.join(['0.5'] * self.count)})",
            "anything": "a value",
            "python": "an object of Python",
        }
        return forms[self.form].replace("a action", "an action")

    def accepts(self, value: Any) -> bool:
        """Tell whether an argument can be this value, in its own unit."""
        if value is None and self.default is None:
            return True
        if self.takes and isinstance(value, self.takes):
            return True
        if self.repeats:
            return all(map(self._is_one, value))
        return self._is_one(value)

    def _is_one(self, value: Any) -> bool:
        match self.form:
            case "number":
                return self._is_number(value)
            case "integer":
                return isinstance(value, int) and self._is_number(value)
            case "numbers":
                is_whole = isinstance(value, list | tuple) and len(value) == self.count
                return is_whole and all(map(self._is_number, value))
            case "text":
                return isinstance(value, str) and (not self.choices or value in self.choices)
            case "flag":
                return isinstance(value, bool)
            case "python":
                return False
        return True

    def _is_number(self, value: Any) -> bool:
        is_finite = isinstance(value, Real) and math.isfinite(value)
        return is_finite and not isinstance(value, bool) and value in self.allowed


def seconds(name: str, text: str = "", **options: Any) -> Parameter:
    """Return a parameter that is a time, s, 0 or more."""
    return Parameter(name, "number", text, **{"unit": "s", "allowed": FROM_0, **options})


# ---- what many faults take ---------------------------------------------------------------------


def steps(low: float, high: float, step: float, instead_of_0: float = 0) -> Drawn:
    """Return what draws a number in steps."""
    return lambda draws, _: number(draws, low, high, step) or instead_of_0


def period(low: float, high: float, step: float) -> Drawn:
    """Return what draws a period, which may be one beside a limit of the mission."""
    return lambda draws, drawable: drawable.period(draws, low, high, step)


def whole(low: int, high: int) -> Drawn:
    """Return what draws an integer."""
    return lambda draws, _: draws.whole(low, high)


def always(value: Any) -> Drawn:
    """Return what gives one value."""
    return lambda *_: value


def any_of(*values: Any) -> Drawn:
    """Return what draws one of some values."""
    return lambda draws, _: one_of(draws, values)


TOPIC = Parameter(
    "topic",
    "text",
    names="topic",
    drawn=lambda draws, present: one_of(draws, tuple(present.topics)),
)
ACTION = Parameter(
    "action", "text", names="action", drawn=lambda draws, present: one_of(draws, present.actions)
)
SERVICE = Parameter(
    "service", "text", names="service", drawn=lambda draws, present: one_of(draws, present.services)
)
GOALS = Parameter(
    "goals", "integer", "After this many the fault ends.", default=None, allowed=FROM_1
)
SHARE = Parameter(
    "share",
    "number",
    "Of the messages, drawn from the mission's seed.",
    default=1.0,
    allowed=SHARE_RANGE,
    by_name=True,
    is_quiet=True,
)
RECEIVER = Parameter("receiver", "text", default=None, names="node", by_name=True)
ON = Parameter("on", "integer", "At which call from now on.", 1, by_name=True, allowed=FROM_1)
ERROR = Parameter("error", "python", default=None, takes=Exception)
MAY_NOT_HAPPEN = Parameter(
    "may_not_happen", "flag", "A run passes in which it does not begin, too.", False, by_name=True
)
LASTING = seconds(
    "lasting",
    "For how long; to the end where it is left out.",
    default=None,
    allowed=ABOVE_0,
    by_name=True,
)
