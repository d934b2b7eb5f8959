"""Limits of single fields of a goal: the accepted values, and the error of others."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, TypeAlias

from action_servers.core.tuning import Tuning
from bt_mission.base.diagnostics import did_you_mean, listed
from bt_mission.base.stamps import NS, to_ns

# A goal field is a float32: 1.82 arrives as 1.8200000525, and must still be within 1.82.
FLOAT32_ROUNDING = 1e-6

SLOWEST_TURN = 0.05
"""rad/s: the lowest rate that is accepted, which is also that of the last part of a turn."""

SLOWEST_DRIVE = 0.01
"""m/s: the lowest speed that is accepted, which is also that of the last millimetres."""

COLOURS = ("red", "yellow", "green", "turquoise", "blue")
"""The colours that are known by name; `camera.colours` has their hues."""


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


@dataclass(frozen=True, slots=True)
class ColourLimit:
    """A text of a goal that names one of the known colours."""

    field: str
    source: str = "the colours that differ by their hue"

    @property
    def words(self) -> str:
        """The accepted values, as text."""
        return listed(COLOURS)

    def fault(self, value: Any) -> str | None:
        """Return why a server refuses a goal with this value, or None."""
        return None if value in COLOURS else f"no such colour '{value[:40]}' (known: {self.words})"

    def hint(self, value: Any) -> str | None:
        """Return the colour that was probably meant, if one is near."""
        return did_you_mean(value, COLOURS)


@dataclass(frozen=True, slots=True)
class JointsLimit:
    """The joints that a goal names: all those of an arm, or some, each once, in any order."""

    field: str
    joints: tuple[str, ...]
    source: str = "arm of the robot"
    needs_all: bool = True

    @property
    def words(self) -> str:
        """The accepted values, as text."""
        return f"{'all' if self.needs_all else 'some'} of {listed(self.joints)}"

    def fault(self, value: Any) -> str | None:
        """Return why a server refuses a goal with these names, or None."""
        unknown = self._unknown(value)
        if unknown is not None:
            known = f"joints: {listed(self.joints)}"
            return f"{self.field}: no joint '{unknown[:60]}' in the arm ({known})"
        twice = next((name for index, name in enumerate(value) if name in value[:index]), None)
        if twice is not None:
            return f"{self.field}: the joint '{twice[:60]}' is named twice"
        missing = [name for name in self.joints if self.needs_all and name not in value]
        return f"{self.field} must name all joints; missing: {listed(missing)}" if missing else None

    def hint(self, value: Any) -> str | None:
        """Return the joint that was probably meant, if one is near."""
        unknown = self._unknown(value)
        return None if unknown is None else did_you_mean(unknown, self.joints)

    def _unknown(self, names: Any) -> str | None:
        return next((name for name in names if name not in self.joints), None)


Limit: TypeAlias = NumberLimit | ColourLimit | JointsLimit
Limits: TypeAlias = tuple[Limit, ...]

LINEAR = "max_linear_velocity of the robot"
ANGULAR = "max_angular_velocity of the robot"
NOT_NEGATIVE = "a time is not negative"
ALLOWANCE = NumberLimit(
    field="time_allowance", low=0.0, high=math.inf, unit="s", source=NOT_NEGATIVE
)
"""The limit of Nav2's recoveries."""


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
    hint = limit.hint(value) if fault and not isinstance(limit, NumberLimit) else None
    return f"{fault}; {hint}" if hint else fault
