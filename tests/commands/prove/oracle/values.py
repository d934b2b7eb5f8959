"""Values of messages, drawn from the whole range of their types and near a mission's numbers."""

from __future__ import annotations

import math
import re
import struct
from random import Random
from typing import Any

RANGES = {
    **{f"int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, 2**bits - 1) for bits in (8, 16, 32, 64)},
    "octet": (0, 255),
}
"""Least and greatest value of the integer types."""
FLOAT32_MAX = 3.4028234e38
_NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?")
_QUOTED = re.compile(r"'([^'\n]*)'|\"([^\"\n]*)\"")
_SEQUENCE = re.compile(r"sequence<(.+?)(?:, \d+)?>")


class Values:
    """Draws values.

    Args:
        draw: The generator.
        text: The mission, whose numbers and texts are of interest.
    """

    def __init__(self, draw: Random, text: str) -> None:
        self._draw = draw
        self.numbers = sorted({sign * float(n) for n in _NUMBER.findall(text) for sign in (1, -1)})
        self._texts = ["", "blue", "other", *(a or b for a, b in _QUOTED.findall(text))]
        self._words = set(re.findall(r"\w+", text))
        self._fields: dict[Any, list[tuple[str, str]]] = {}

    def of(self, kind: str) -> Any:
        """Return a value of a type of ROS messages."""
        draw = self._draw
        if kind == "boolean":
            return draw.random() < 0.5
        if kind.startswith(("string", "wstring")):
            return draw.choice(self._texts)
        if kind in RANGES:
            low, high = RANGES[kind]
            drawn = self._real()
            whole = 0 if not math.isfinite(drawn) else round(drawn)
            if draw.random() < 0.1:
                whole = draw.choice((low, high, draw.randint(low, high)))
            return min(max(whole, low), high)
        if kind == "double":
            return self._real()
        if kind == "float":
            return to_float32(self._real())
        sequence = _SEQUENCE.fullmatch(kind)
        if sequence is not None:
            return [self.of(sequence[1]) for _ in range(draw.choice((0, 1, 1, 2, 5)))]
        raise ValueError(kind)

    def fill(self, message: Any) -> Any:
        """Give the fields that the mission may read random values; return the message."""
        for name, kind in self._read_of(type(message)):
            if kind:
                setattr(message, name, self.of(kind))
            else:
                self.fill(getattr(message, name))
        return message

    def read_of(self, message: Any) -> list[tuple[str, Any]]:
        """Return the fields that the mission may read, with their values."""
        return [(name, getattr(message, name)) for name, _ in self._read_of(type(message))]

    def _read_of(self, kind: Any) -> list[tuple[str, str]]:
        known = self._fields.get(kind)
        if known is None:
            named = [
                pair for pair in kind.get_fields_and_field_types().items() if pair[0] in self._words
            ]
            known = self._fields[kind] = [
                (name, "" if "/" in field else field)
                for name, field in named
                if not re.search(r"\[\d+\]$|<.*/", field)
            ]
        return known

    def _real(self) -> float:
        """Return a number: between two of the mission's, at or beside one, or anywhere."""
        draw, numbers = self._draw, self.numbers
        way = draw.random()
        if way < 0.4 and len(numbers) > 1:
            index = draw.randrange(len(numbers) - 1)
            return draw.uniform(numbers[index], numbers[index + 1])
        if way < 0.75 and numbers:
            number = draw.choice(numbers)
            beside = (0.0, 0.0, math.ulp(number), -math.ulp(number), 1e-4, -1e-4, 0.5, -0.5, 1, -1)
            return number + draw.choice(beside)
        if way < 0.95:
            scale = draw.choice((0.0, 1e-6, 0.1, 1.0, 10.0, 1e3, 1e9, 1e30))
            return draw.uniform(-scale, scale)
        return draw.choice((math.nan, math.inf, -math.inf, FLOAT32_MAX, -FLOAT32_MAX))


def to_float32(value: float) -> float:
    """Return the nearest number that a field of 32 bits can have."""
    if math.isfinite(value) and abs(value) > FLOAT32_MAX:
        return math.copysign(FLOAT32_MAX, value)
    return float(struct.unpack("f", struct.pack("f", value))[0])
