"""From what is written for a fault's arguments to their values; units are turned into its own."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from bt_mission.base.diagnostics import describe, did_you_mean, listed, quoted
from bt_mission.base.stamps import MOST_SECONDS
from bt_mission.base.units import UNITS, converted
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.requirements.language.formula import CONTROL_STEP_S
from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.scenarios.faults.faults import FAULTS
from bt_mission.scenarios.faults.parameters import LASTING, MAY_NOT_HAPPEN, Parameter, seconds
from bt_mission.scenarios.faults.planned import Beginning, PlannedFault, Value

TIME = seconds("time")


@dataclass(frozen=True)
class WrittenQuantity:
    """A number with the unit behind it, and the unit's column."""

    number: int | float
    unit: str
    column: int = 1


@dataclass(frozen=True)
class Given:
    """The written value of an argument, and its column."""

    value: Any
    column: int = 1


class ArgumentReader:
    """Takes the arguments of one fault, each by its position or its name.

    Raises:
        ExpressionError: For an unknown fault, with the column.
    """

    def __init__(self, name: str, column: int = 1) -> None:
        if name not in FAULTS:
            near = did_you_mean(name, FAULTS)
            known = "" if near else f" (known: {listed(FAULTS, len(FAULTS))})"
            raise ExpressionError("BT-702", f"unknown fault {quoted(name)}{known}", column, near)
        self._kind = FAULTS[name]
        self._column = column
        self._arguments: dict[str, Value] = {}
        self._lasting: float | None = None
        self._bare: set[str] = set()
        self._may_not_happen: bool | None = None
        self._free = [
            parameter for parameter in self._kind.parameters.values() if not parameter.by_name
        ]

    def knows(self, name: str) -> bool:
        """Tell whether an argument has this name."""
        return name in ("lasting", MAY_NOT_HAPPEN.name) or name in self._kind.parameters

    @property
    def name(self) -> str:
        """Of the fault."""
        return self._kind.name

    def takes(self, name: str) -> bool:
        """Tell whether the fault takes an argument of this name."""
        return self._kind.takes_fields or name in self._kind.optional

    def is_flag(self, name: str) -> bool:
        """Tell whether this is an argument that is on where its name stands alone."""
        if name == MAY_NOT_HAPPEN.name:
            return True
        return name in self._kind.parameters and self._kind.parameters[name].form == "flag"

    def is_next(self, name: str) -> bool:
        """Tell whether the next value by position is one of this argument."""
        return any(unset.name == name for unset in self._unset()[:1])

    def has_unit(self, name: str | None) -> bool:
        """Tell whether the argument of this name, or else the next one by position, has a unit."""
        if name == "lasting":
            return True
        parameter = self._kind.parameters.get(name) if name else next(iter(self._unset()), None)
        return bool(parameter and parameter.unit)

    def by_position(self, given: Given) -> None:
        """Take the value of the next argument."""
        parameter = next(iter(self._unset()), None)
        if parameter is None:
            message = f"unexpected {_described(given.value)}"
            near = did_you_mean(str(given.value), self._kind.optional)
            raise ExpressionError(
                "BT-703", message, given.column, near or f"write '{self._kind.usage}'"
            )
        value = argument_value(parameter, given.value, given.column)
        self._note_bare(parameter.name, given)
        if parameter.repeats:
            before = self._arguments.get(parameter.name, ())
            assert isinstance(before, tuple)
            self._arguments[parameter.name] = (*before, value)
        else:
            self._arguments[parameter.name] = value

    def by_name(self, name: str, given: Given, column: int) -> None:
        """Take the value of the argument of a name, which stands at a column."""
        kind = self._kind
        others = {"lasting": self._lasting, MAY_NOT_HAPPEN.name: self._may_not_happen}
        if name in self._arguments or others.get(name) is not None:
            raise ExpressionError("BT-703", f"'{name}' is given twice", column)
        self._note_bare(name, given)
        if name == "lasting":
            self._lasting = self._read_lasting(given, column)
        elif name == MAY_NOT_HAPPEN.name:
            self._may_not_happen = bool(argument_value(MAY_NOT_HAPPEN, given.value, given.column))
        elif name in kind.parameters:
            self._arguments[name] = _argument(kind.parameters[name], given)
        elif kind.takes_fields:
            self._arguments[name] = _anything(given)
        else:
            message = f"{kind.name} has no argument {quoted(name)} (known: {listed(kind.optional)})"
            raise ExpressionError("BT-703", message, column, did_you_mean(name, kind.optional))

    def planned(self, begins: Beginning) -> PlannedFault:
        """Return the fault with the arguments that were taken.

        Raises:
            ExpressionError: When one is missing, or the fault refuses one.
        """
        missing = [
            parameter.name
            for parameter in self._kind.parameters.values()
            if parameter.is_required and parameter.name not in self._arguments
        ]
        if missing:
            message = f"{self._kind.name} needs {' and '.join(missing)}"
            raise ExpressionError("BT-703", message, self._column, f"write '{self._kind.usage}'")
        bare = frozenset(self._bare)
        planned = PlannedFault(
            begins,
            self._kind.name,
            self._arguments,
            self._lasting,
            bare,
            may_not_happen=self._may_not_happen is True,
        )
        try:
            planned.make()
        except ScenarioError as error:
            raise ExpressionError("BT-703", str(error), self._column) from None
        return planned

    def _note_bare(self, name: str, given: Given) -> None:
        if isinstance(given.value, int | float):
            self._bare.add(name)

    def _unset(self) -> list[Parameter]:
        return [
            parameter
            for parameter in self._free
            if parameter.repeats or parameter.name not in self._arguments
        ]

    def _read_lasting(self, given: Given, column: int) -> float:
        if not self._kind.lasts:
            raise ExpressionError(
                "BT-703", f"{self._kind.name} has no duration, so no 'lasting'", column
            )
        value = argument_value(LASTING, given.value, given.column)
        assert isinstance(value, int | float)
        if value < CONTROL_STEP_S:
            message = f"{value:g} s is shorter than a control step of {CONTROL_STEP_S:g} s"
            raise ExpressionError("BT-703", message, given.column)
        return value


def planned_fault(begins: Beginning, name: str, /, *arguments: Any, **options: Any) -> PlannedFault:
    """Return a fault of arguments as the method of ``stage.faults`` takes them.

    Raises:
        ExpressionError: For an unknown name or argument.
    """
    reader = ArgumentReader(name)
    for value in arguments:
        reader.by_position(Given(value))
    for key, value in options.items():
        reader.by_name(key, Given(value), 1)
    return reader.planned(begins)


def _argument(parameter: Parameter, given: Given) -> Value:
    """Return what is written for an argument by its name."""
    if not parameter.repeats:
        return argument_value(parameter, given.value, given.column)
    values = given.value
    if not isinstance(values, list | tuple) or not values:
        raise ExpressionError(
            "BT-703", f"expected a list, each of {parameter.expected}", given.column
        )
    if not isinstance(values[0], list | tuple):
        values = (values,)
    return tuple(argument_value(parameter, value, given.column) for value in values)


def argument_value(parameter: Parameter, value: Any, column: int) -> Value:
    """Return the value of an argument in its own unit.

    Raises:
        ExpressionError: For a value that it cannot be.
    """
    converted = _converted(parameter, value, column)
    if converted is None or not (
        parameter.accepts((converted,)) if parameter.repeats else parameter.accepts(converted)
    ):
        got = quoted(value) if parameter.choices and isinstance(value, str) else _described(value)
        message = f"expected {parameter.expected} for '{parameter.name}', got {got}"
        raise ExpressionError(
            "BT-703", message, column, did_you_mean(str(value), parameter.choices)
        )
    number = converted if isinstance(converted, int | float) else 0.0
    if parameter.unit == "s" and abs(number) > MOST_SECONDS:
        text = f"expected at most {MOST_SECONDS:,} s for '{parameter.name}', got {number:g}"
        raise ExpressionError("BT-703", text, column)
    return converted


def _converted(parameter: Parameter, value: Any, column: int) -> Value | None:
    """Return a value in the unit of its argument; None for one of another form."""
    match parameter.form, value:
        case "number", str() if re.match(r"\s*[-+.0-9]", value):
            return _text_number(parameter, value, column)
        case "number", int() | float() | WrittenQuantity():
            return _in_unit(parameter, value)
        case "numbers", list() | tuple() if len(value) == parameter.count:
            return tuple(argument_value(_single(parameter), part, column) for part in value)
        case "integer" | "flag" | "text", bool() | int() | float() | str():
            return value
        case "anything", _:
            return _anything(Given(value, column))
    return None


def _single(parameter: Parameter) -> Parameter:
    return Parameter(parameter.name, "number", unit=parameter.unit, allowed=parameter.allowed)


def _text_number(parameter: Parameter, text: str, column: int) -> float | None:
    """Return a number that is written as text with its unit, such as ``2 s``; else None."""
    match = re.fullmatch(r"\s*([-+0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(\S+)\s*", text)
    try:
        number = float(match[1]) if match else None
    except ValueError:
        number = None
    if match is None or number is None:
        return None
    return _in_unit(parameter, WrittenQuantity(number, match[2], column))


def _in_unit(parameter: Parameter, value: float | WrittenQuantity) -> float:
    """Return a number in the unit of its argument."""
    if not isinstance(value, WrittenQuantity):
        return value
    fitting = [name for name, (_, base) in UNITS.items() if base == _base(parameter.unit)]
    if value.unit not in fitting:
        what = f"{parameter.unit and 'a unit of'} {parameter.unit}".strip()
        units = f"is in {parameter.unit} ({', '.join(fitting)})" if what else "has no unit"
        message = f"'{parameter.name}' {units}, got {quoted(value.unit)}"
        raise ExpressionError("BT-703", message, value.column, did_you_mean(value.unit, fitting))
    return converted(value.number, value.unit, parameter.unit)


def _base(unit: str) -> str:
    return UNITS[unit][1] if unit else ""


def _anything(given: Given) -> Value:
    match given.value:
        case bool() | int() | float() | str():
            return given.value
        case list() | tuple():
            return tuple(_anything(Given(part, given.column)) for part in given.value)
    message = f"expected a number, a text or a list, got {_described(given.value)}"
    raise ExpressionError("BT-703", message, given.column)


def _described(value: Any) -> str:
    return (
        f"{value.number:g} {value.unit}" if isinstance(value, WrittenQuantity) else describe(value)
    )
