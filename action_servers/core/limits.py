"""Limits of single fields of a goal: the accepted values, and the error of others."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, Protocol, TypeAlias

from action_servers.core.tuning import Tuning
from bt_mission.base.diagnostics import did_you_mean, listed
from bt_mission.base.stamps import NS, to_ns

# A goal field is a float32: 1.82 arrives as 1.8200000525, and must still be within 1.82.
FLOAT32_ROUNDING = 1e-6

SLOWEST_TURN = 0.05
"""rad/s: the lowest rate that is accepted, which is also that of the last part of a turn."""

SLOWEST_DRIVE = 0.01
"""m/s: the lowest speed that is accepted, which is also that of the last millimetres."""


def outside(name: str, value: float, low: float, high: float, unit: str) -> str | None:
    """Return why `value` is not a number from `low` to `high`, or None if it is.

    NaN and infinities are always outside. Both limits belong to the range.
    """
    low_slack = FLOAT32_ROUNDING * abs(low)
    high_slack = FLOAT32_ROUNDING * abs(high)
    if math.isfinite(value) and low - low_slack <= value <= high + high_slack:
        return None
    return f"{name} must be from {low:g} to {high:g} {unit}, got {value:g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class NumberLimit:
    """A number of a goal, from `low` to `high`, both included.

    Args:
        field: Its name in the goal, dotted if it is nested; a duration counts in seconds.
        source: The source of the limit, as text.
        zero: The meaning of 0, if it is accepted besides the range; "" if it is not.
        above: Whether the number must be above `low`.
    """

    field: str
    low: float
    high: float
    unit: str
    source: str
    zero: str = ""
    above: bool = False

    @property
    def words(self) -> str:
        """The accepted values, as text."""
        if math.isinf(self.high):
            return f"{self.low:g} {self.unit} or more"
        if self.above:
            return f"above {self.low:g} and at most {self.high:g} {self.unit}"
        return f"from {self.low:g} to {self.high:g} {self.unit}"

    def fault(self, value: Any) -> str | None:
        """Return why a server refuses a goal with this value, or None."""
        if self.zero and value == 0.0:
            return None
        if math.isinf(self.high):
            fits = self.low <= value < math.inf
            return None if fits else f"{self.field} must be {self.words}, got {value:g}"
        why = outside(self.field, value, self.low, self.high, self.unit)
        if self.above and (why is not None or value == self.low):
            return f"{self.field} must be {self.words}, got {value:g}"
        return why

    def hint(self, _value: Any) -> str | None:
        """Return nothing: no number is meant by another."""
        return None


@dataclass(frozen=True, slots=True, kw_only=True)
class ChoiceLimit:
    """A text of a goal that is one of some choices.

    Args:
        field: Its name in the goal.
        what: What the text names, for messages.
        choices: The accepted texts.
        source: The source of the choices, as text.
    """

    field: str
    what: str
    choices: tuple[str, ...]
    source: str

    @property
    def words(self) -> str:
        """The accepted values, as text."""
        return listed(self.choices)

    def fault(self, value: Any) -> str | None:
        """Return why a server refuses a goal with this value, or None."""
        if value in self.choices:
            return None
        return f"no such {self.what} '{value[:40]}' (known: {self.words})"

    def hint(self, value: Any) -> str | None:
        """Return the choice that was probably meant, if one is near."""
        return did_you_mean(value, self.choices)


class Limit(Protocol):
    """Which values a field of a goal may have."""

    @property
    def field(self) -> str:
        """Its name in the goal, dotted if it is nested."""

    @property
    def source(self) -> str:
        """The source of the limit, as text."""

    @property
    def words(self) -> str:
        """The accepted values, as text."""

    def fault(self, value: Any) -> str | None:
        """Return why a server refuses a goal with this value, or None."""

    def hint(self, value: Any) -> str | None:
        """Return the value that was probably meant, if one is near."""


Limits: TypeAlias = tuple[Limit, ...]

LINEAR = "max_linear_velocity of the robot"
ANGULAR = "max_angular_velocity of the robot"
NOT_NEGATIVE = "a time is not negative"


def parameter(name: str) -> str:
    """Return a parameter of the servers as the source of a limit."""
    return f"parameter {name} of the servers"


def duration_limit(field: str, tuning: Tuning) -> NumberLimit:
    """Return the limit of a whole number of seconds."""
    longest, source = tuning.duration_limit, parameter("duration_limit")
    return NumberLimit(field=field, low=1, high=longest, unit="s", source=source)


OVERSHOOT_DEG = 5.0
"""The overshoot of a rotation, and the error of odometry, with a large reserve."""

OVERSHOOT_M = 0.1
"""The same for a way."""

UNBOUNDED = (0.0, math.inf)
"""The range of a feedback that only is not negative."""


def around(target: float, slack: float) -> tuple[float, float]:
    """Return the range of a feedback from 0 to a target of either sign, with some slack."""
    return min(0.0, target) - slack, max(0.0, target) + slack


def faults(goal: Any, limits: Limits) -> Iterator[str | None]:
    """Yield for each limit why a goal message is refused, or None."""
    for limit in limits:
        value = attrgetter(limit.field)(goal)
        yield reason(limit, to_ns(value) / NS if hasattr(value, "nanosec") else value)


def reason(limit: Limit, value: Any) -> str | None:
    """Return why a value is refused, with what was probably meant, or None."""
    fault = limit.fault(value)
    hint = limit.hint(value) if fault else None
    return f"{fault}; {hint}" if hint else fault
