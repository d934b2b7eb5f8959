"""A fault as data: which it is, with what arguments, and when it begins."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

from bt_mission.base.diagnostics import Diagnostic, diagnostic_at
from bt_mission.requirements.language.formula import Condition
from bt_mission.scenarios.faults.fault import Fault
from bt_mission.scenarios.faults.faults import FAULTS
from bt_mission.scenarios.faults.kind import FaultKind
from bt_mission.scenarios.faults.parameters import MAY_NOT_HAPPEN

Value: TypeAlias = "bool | int | float | str | tuple[Value, ...]"
"""The type of an argument."""

WORD = re.compile(r"[A-Za-z_/~][\w/.~]*")
"""A text that needs no quotes."""

Locate: TypeAlias = Callable[[str, str, str | None, str, int], Diagnostic]
"""Makes a diagnostic of code, message, hint, a part of a fault's text and an offset in it."""

OPTION = "--fault"

_DELAYS = frozenset(("delay", "delay_feedback", "delay_service"))
"""Faults whose delays are usually milliseconds; results and answers may be late by minutes."""

_LONG_DELAY_S = 20.0
"""A number without a unit is taken for milliseconds from here: no network delays by so long."""


@dataclass(frozen=True)
class AtTime:
    """At a time, s since the start: after the measurements of that instant, before all else."""

    time_s: float

    def __str__(self) -> str:
        return f"at {self.time_s!r}"


@dataclass(frozen=True)
class AfterStep:
    """Once the first control step at a time or later is over, s since the start."""

    time_s: float

    def __str__(self) -> str:
        return f"after {self.time_s!r}"


@dataclass(frozen=True)
class WhenTrue:
    """Once the first control step is over at which a condition has been true for so long, s."""

    condition: Condition
    held_s: float = 0.0

    def __str__(self) -> str:
        held = f" for {self.held_s!r} s" if self.held_s else ""
        return f"when {self.condition.text}{held}"


Beginning: TypeAlias = AtTime | AfterStep | WhenTrue


@dataclass(frozen=True, repr=False)
class PlannedFault:
    """A fault that is to begin in a run.

    Attributes:
        begins: When.
        name: Of the fault.
        arguments: By the names of the parameters; those that repeat have a tuple of values.
        lasting: S of virtual time; None is to the end of the run.
        bare: The arguments that were written as numbers without a unit.
        may_not_happen: Does a run pass in which it does not begin?
        robot: Of a fleet: the robot that it is for; empty is each.
        place: Where it is written; None is in its own text.
    """

    begins: Beginning
    name: str
    arguments: Mapping[str, Value] = field(default_factory=dict)
    lasting: float | None = None
    bare: frozenset[str] = field(default=frozenset(), compare=False)
    may_not_happen: bool = False
    robot: str = ""
    place: Locate | None = field(default=None, compare=False)

    def __repr__(self) -> str:
        return f"<{self.text}>"

    @property
    def kind(self) -> FaultKind:
        """The row of the table of faults."""
        return FAULTS[self.name]

    def make(self) -> Fault:
        """Make the fault.

        Raises:
            ScenarioError: When the arguments are not what the fault takes.
        """
        repeats = [
            parameter.name for parameter in self.kind.parameters.values() if parameter.repeats
        ]
        several = [value for name in repeats for value in self._several(name)]
        named = {name: argument for name, argument in self.arguments.items() if name not in repeats}
        if self.lasting is not None:
            named["lasting"] = self.lasting
        return self.kind.make(*several, **named)

    def locate(
        self, code: str, message: str, hint: str | None = None, part: str = "", offset: int = 0
    ) -> Diagnostic:
        """Return a diagnostic of a part of the fault as it is written; without one, of all."""
        place = self.place or within(self.text)
        return place(code, message, hint, part, offset)

    def doubts(self) -> Iterator[Diagnostic]:
        """Yield a warning for each delay without a unit that looks as if in milliseconds."""
        if self.name not in _DELAYS:
            return
        for name in sorted(self.bare & {"by", "jitter"}):
            value = self.arguments.get(name)
            if isinstance(value, int | float) and value >= _LONG_DELAY_S:
                message = f"'{name}' is in seconds: {value:g} s; {value:g} ms?"
                hint = f"write '{value:g} ms' or '{value:g} s'"
                doubt = self.locate("BT-710", message, hint, f"{value:g}")
                yield replace(doubt, severity="warning")

    @property
    def text(self) -> str:
        """How it is written: ``at 5.0: drop scan lasting 2``."""
        return f"{self.begins}: {self.call}{f' {MAY_NOT_HAPPEN.name}' * self.may_not_happen}"

    @property
    def call(self) -> str:
        """The same without the time."""
        parts = [self.name]
        in_order = True
        for parameter in self.kind.parameters.values():
            if parameter.name not in self.arguments:
                in_order = False
            elif parameter.repeats:
                parts += [self._shown(value) for value in self._several(parameter.name)]
            else:
                in_order = in_order and parameter.is_required
                shown = self._shown(self.arguments[parameter.name])
                parts.append(shown if in_order else f"{parameter.name} {shown}")
        others = self.arguments.keys() - self.kind.parameters.keys()
        parts += [f"{name}={self._shown(self.arguments[name])}" for name in sorted(others)]
        parts += [] if self.lasting is None else [f"lasting {self.lasting!r}"]
        return " ".join(parts)

    def _several(self, name: str) -> tuple[Value, ...]:
        values = self.arguments.get(name, ())
        assert isinstance(values, tuple)
        return values

    def _shown(self, value: Any) -> str:
        match value:
            case bool():
                return "true" if value else "false"
            case tuple() | list():
                return f"({', '.join(map(self._shown, value))})"
            case float() if not math.isfinite(value):
                return repr(value).replace("inf", ".inf").replace("nan", ".nan")
            case str():
                is_word = WORD.fullmatch(value) and value not in self._reserved
                return value if is_word else json.dumps(value)
        return repr(value)

    @property
    def _reserved(self) -> frozenset[str]:
        return frozenset((*self.kind.parameters, "lasting", MAY_NOT_HAPPEN.name, "true", "false"))


def within(text: str, start: int = 0) -> Locate:
    """Return what finds places in the text of an option, from an offset on."""

    def locate(code: str, message: str, hint: str | None, part: str, offset: int) -> Diagnostic:
        column = max(text.find(part, start), start) + offset + 1
        return diagnostic_at(code, (1, column), OPTION, [text], message, hint)

    return locate
