"""The functions of the expression language. Angles are radians unless a name says degrees."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from bt_mission.language.expressions.values import Plain, Type

Draw = random.Random


@dataclass(frozen=True)
class Function:
    """A function: its arguments, its result, and its line in the documentation.

    `takes` is the type of every argument (None: any). `random` functions draw from the
    generator that the evaluation was given.
    """

    usage: str
    apply: Callable[..., Plain]
    least: int = 1
    most: int = 1
    takes: Type | None = "number"
    gives: Type | None = "number"
    random: bool = False


def _sign(x: float) -> int:
    return (x > 0) - (x < 0)


MOST_DIGITS = 400
"""Beyond the range of a float; rounding to more would compute powers of ten without end."""


def _round(x: float, digits: float = 0) -> float:
    if not -MOST_DIGITS <= digits <= MOST_DIGITS:
        raise ValueError(f"expected {-MOST_DIGITS} to {MOST_DIGITS} digits, got {digits}")
    return round(x, int(digits)) if digits else round(x)


def _clamp(x: float, low: float, high: float) -> float:
    if low > high:
        raise ValueError(f"the lower limit {low} is above the upper limit {high}")
    return min(max(x, low), high)


def _uniform(draw: Draw, low: float, high: float) -> float:
    return low + (high - low) * draw.random()


def _choice(draw: Draw, *values: Plain) -> Plain:
    of: Sequence[Plain] = values
    if len(values) == 1 and isinstance(values[0], list | tuple):
        of = values[0]
    if not of:
        raise ValueError("nothing to choose from")
    # random() is the one method whose sequence Python promises never to change.
    return of[int(draw.random() * len(of))]


def _levy(draw: Draw, shortest: float, longest: float) -> float:
    """Draw the step length of a Lévy flight: density falls with the square of the length."""
    if not 0 < shortest <= longest < math.inf:
        raise ValueError(f"expected 0 < shortest <= longest, got {shortest} and {longest}")
    share = draw.random()
    return 1.0 / (1.0 / shortest - share * (1.0 / shortest - 1.0 / longest))


def _length(of: Any) -> int:
    return len(of)


MANY = 100

FUNCTIONS: dict[str, Function] = {
    "abs": Function("abs(x)", abs, gives=None),
    "atan2": Function("atan2(y, x)", math.atan2, 2, 2),
    "ceil": Function("ceil(x)", math.ceil, gives="integer"),
    "choice": Function(
        "choice(a, b, ...) or choice(list)", _choice, 1, MANY, takes=None, gives=None, random=True
    ),
    "clamp": Function("clamp(x, low, high)", _clamp, 3, 3, gives=None),
    "copysign": Function("copysign(size, sign)", math.copysign, 2, 2),
    "cos": Function("cos(x)", math.cos),
    "degrees": Function("degrees(radians)", math.degrees),
    "floor": Function("floor(x)", math.floor, gives="integer"),
    "hypot": Function("hypot(x, y)", math.hypot, 2, 2),
    "len": Function("len(list)", _length, takes="list", gives="integer"),
    "levy": Function("levy(shortest, longest)", _levy, 2, 2, random=True),
    "max": Function("max(a, b, ...)", max, 2, MANY, gives=None),
    "min": Function("min(a, b, ...)", min, 2, MANY, gives=None),
    "radians": Function("radians(degrees)", math.radians),
    "round": Function("round(x) or round(x, digits)", _round, 1, 2, gives=None),
    "sign": Function("sign(x)", _sign, gives="integer"),
    "sin": Function("sin(x)", math.sin),
    "sqrt": Function("sqrt(x)", math.sqrt),
    "tan": Function("tan(x)", math.tan),
    "uniform": Function("uniform(low, high)", _uniform, 2, 2, random=True),
}


def result_type(name: str, arguments: Sequence[Type | None]) -> Type | None:
    """Return the type a call gives, for arguments of these types."""
    if name == "round":
        return "integer" if len(arguments) == 1 else "number"
    if name == "choice":
        return arguments[0] if len({*arguments} - {"list"}) == 1 else None
    gives = FUNCTIONS[name].gives
    if gives is not None:
        return gives
    if all(argument_type == "integer" for argument_type in arguments):
        return "integer"
    return None if None in arguments else "number"
