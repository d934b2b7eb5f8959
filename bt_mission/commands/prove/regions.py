"""The regions of a value: stretches of a number line on which an expression does the same.

The borders are found by bisection among the numbers that a type has, with the expression itself.
So they are exact in the precision of the type. This needs an expression that only rises or only
falls between its borders, and :class:`Splitter` follows no other.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from random import Random
from typing import Any, TypeAlias

from bt_mission.language.expressions.syntax import (
    Arithmetic,
    Comparison,
    Conditional,
    Constant,
    EvaluationScope,
    FunctionCall,
    Logic,
    Name,
    Negation,
    Not,
    SyntaxNode,
)
from bt_mission.language.expressions.values import ExpressionError

MOST_USUAL = 1e12
"""Numbers beyond it are a fault, as infinite ones and NaN are."""
DRAW = ""
"""In place of the name of a value: the number from 0 to 1 that an expression draws."""

Span: TypeAlias = tuple[int, int]
"""The first and the last position of a stretch."""


_RISING = frozenset(("floor", "ceil", "sign", "degrees", "radians"))
_RISING_FIRST = frozenset(("round", "clamp"))
"""Functions that rise with their first argument."""
_TURNING = frozenset(("abs", "sqrt", "hypot", "copysign"))
"""Functions that fall up to zero and rise behind it, or have no value there."""
_TURNING_BOTH = frozenset(("hypot", "copysign"))
"""Those that do so with their second argument, too."""


class UnfollowedError(Exception):
    """A value cannot be followed through an expression; says why."""


class Failed:
    """In place of the value of an expression that raises an error."""

    def __repr__(self) -> str:
        return "an error"


FAILED = Failed()


@dataclass(frozen=True)
class Line:
    """The numbers of a type in their order, each at a position.

    Attributes:
        kind: "double", "float", "integer" or "draw".
    """

    kind: str
    first: int
    last: int

    @classmethod
    def of_float(cls, kind: str, most: float = MOST_USUAL) -> Line:
        """Return the floats up to a magnitude."""
        last = _bits(most, kind)
        if _number(last, kind) > most:
            last -= 1
        return cls(kind, -last, last)

    @property
    def is_whole(self) -> bool:
        """Does it hold integers?"""
        return self.kind == "integer"

    def at(self, position: int) -> float:
        """Return the number at a position."""
        match self.kind:
            case "integer":
                return position
            case "draw":
                return position * 2.0**-53
        return _number(position, self.kind) if position >= 0 else -_number(-position, self.kind)

    def representative(self, span: Span) -> float:
        """Return a number of a stretch that is short to write."""
        first, last = span
        low, high = self.at(first), self.at(last)
        for candidate in _short(low, high, is_whole=self.is_whole):
            number = _rounded(candidate, self.kind)
            if low <= number <= high:
                return number
        return self.at((first + last) // 2)


def _bits(number: float, kind: str) -> int:
    form, whole = ("f", "i") if kind == "float" else ("d", "q")
    bits: int = struct.unpack(f"<{whole}", struct.pack(f"<{form}", number))[0]
    return bits


def _number(bits: int, kind: str) -> float:
    form, whole = ("f", "i") if kind == "float" else ("d", "q")
    number: float = struct.unpack(f"<{form}", struct.pack(f"<{whole}", bits))[0]
    return number


DRAWN = Line("draw", 0, 2**53 - 1)
DOUBLES = Line.of_float("double", 1.7e308)


def _rounded(number: float, kind: str) -> float:
    if kind == "float":
        rounded: float = struct.unpack("<f", struct.pack("<f", number))[0]
        return rounded
    if kind == "draw":
        return round(number * 2**53) / 2**53
    return number


def _short(low: float, high: float, *, is_whole: bool) -> Iterator[float]:
    """Yield numbers from the simplest on; some of them lie between these two."""
    kind: type[float] = int if is_whole else float
    yield kind(0)
    near, far = sorted((low, high), key=abs)
    if near == far:
        yield near
        return
    if abs(far - near) > 2:  # a little farther than the end near zero
        step = 1 if far > near else -1
        yield kind(math.trunc(near) + step)
        yield kind(math.trunc(near) + 2 * step)
    middle = low + (high - low) / 2
    if not is_whole:
        for digits in range(17):
            yield round(middle, digits)
    yield kind(middle)


class _Drawing(Random):
    """Draws one number, always the same."""

    def __init__(self, number: float) -> None:
        super().__init__(0)
        self._number = number

    def random(self) -> float:
        return self._number


_NO_DRAW = _Drawing(0.5)


def evaluated(root: SyntaxNode, name: str, value: Any, others: Mapping[str, Any]) -> Any:
    """Return what an expression gives for a value; `FAILED` where it raises an error.

    Args:
        root: Its parts.
        name: Of the value; `DRAW` for the number that is drawn.
        others: The values of other names.
    """
    draw = _Drawing(value) if name == DRAW else _NO_DRAW
    variables = others if name == DRAW else {**others, name: value}
    try:
        return root.evaluate(EvaluationScope(variables, {}, draw))
    except ExpressionError:
        return FAILED


def reads(root: SyntaxNode, name: str) -> bool:
    """Does an expression depend on a value?"""
    if isinstance(root, Name):
        return root.name == name
    if isinstance(root, FunctionCall) and root.draws and name == DRAW:
        return True
    return any(reads(part, name) for part in root.parts)


class Splitter:
    """Finds the borders of a value on a line.

    Args:
        line: The numbers that the value may have.
        name: Of the value, in expressions; `DRAW` for the number that is drawn.
        others: The values of other names.
    """

    def __init__(self, line: Line, name: str, others: Mapping[str, Any]) -> None:
        self._line, self._name, self.others = line, name, others
        self._begins = {line.first}
        """The first position of each stretch."""

    @property
    def spans(self) -> list[Span]:
        """The stretches."""
        begins = sorted(self._begins)
        ends = [begin - 1 for begin in begins[1:]]
        return list(zip(begins, [*ends, self._line.last], strict=True))

    def follow(self, root: SyntaxNode) -> None:
        """Split where an expression begins to do something else.

        Behind it the expression rises, falls or is constant on each stretch, or is an error.

        Raises:
            UnfollowedError: It is not known to be so.
        """
        if not self._depends(root):
            return
        for part in root.parts:
            self.follow(part)
        match root:
            case Name() | Logic() | Not() | Negation() | Conditional():
                pass
            case Comparison():
                self._compare(root)
            case Arithmetic():
                self._compute(root)
            case FunctionCall():
                self._call(root)
            case _:
                raise UnfollowedError
        self._split_errors(root)

    def level(self, root: SyntaxNode, number: float) -> None:
        """Split where an expression that was followed is below, at and above a number."""
        self._split(lambda position: _side(self._value(root, position), number))

    # ---- the parts of expressions ------------------------------------------------------------

    def _depends(self, root: SyntaxNode) -> bool:
        return reads(root, self._name)

    def _compare(self, root: Comparison) -> None:
        sides = root.parts
        for left, right in pairwise(sides):
            if self._depends(left) and self._depends(right):
                self._need_opposed(left, right)
            self._split(
                lambda position, left=left, right=right: _side(  # type: ignore[misc]
                    self._value(left, position), self._value(right, position)
                )
            )

    def _compute(self, root: Arithmetic) -> None:
        left, right, symbol = root.left, root.right, root.symbol
        both = self._depends(left) and self._depends(right)
        match symbol:
            case "+" if both:
                self._need_alike(left, right)
            case "-" if both:
                self._need_opposed(left, right)
            case "*" if both:
                self._zero(left, right)
                self._need_alike(left, right, magnitude=True)
            case "+" | "-" | "*":
                pass
            case "/" | "//" if not both:
                self._zero(right)
            case "**" if not both:
                self._zero(left, right)
                if self._depends(right):
                    self.level(right, 0)
                if not self._depends(left) and not self._is_positive(left):
                    raise UnfollowedError
            case _:
                raise UnfollowedError

    def _call(self, root: FunctionCall) -> None:
        arguments, name = root.arguments, root.name
        inner = [argument for argument in arguments if self._depends(argument)]
        is_first = inner == [arguments[0]]
        if name == "choice" and not inner:
            self._choose(root)
        elif name in ("min", "max"):
            for argument in inner[1:]:
                self._need_alike(inner[0], argument)
        elif name in _TURNING and len(inner) == 1 and (is_first or name in _TURNING_BOTH):
            self._zero(inner[0])
        elif not (name in _RISING or (name in _RISING_FIRST and is_first) or not inner):
            raise UnfollowedError

    def _choose(self, root: FunctionCall) -> None:
        """Split where another element is drawn."""
        count = self._count(root)
        for index in range(1, count):
            share = index / count
            self._split(lambda position, share=share: self._line.at(position) >= share)  # type: ignore[misc]

    def _is_positive(self, root: SyntaxNode) -> bool:
        value = self._value(root, self._line.first)
        return isinstance(value, int | float) and value > 0

    def _count(self, root: FunctionCall) -> int:
        if len(root.arguments) > 1:
            return len(root.arguments)
        value = self._value(root.arguments[0], self._line.first)
        return len(value) if isinstance(value, list | tuple) else 1

    def _zero(self, *roots: SyntaxNode) -> None:
        for root in roots:
            if self._depends(root):
                self.level(root, 0)

    def _need_alike(self, left: SyntaxNode, right: SyntaxNode, *, magnitude: bool = False) -> None:
        self._need(left, right, 1, magnitude=magnitude)

    def _need_opposed(self, left: SyntaxNode, right: SyntaxNode) -> None:
        self._need(left, right, -1, magnitude=False)

    def _need(self, left: SyntaxNode, right: SyntaxNode, sign: int, *, magnitude: bool) -> None:
        for span in self.spans:
            slopes = [self._slope(root, span, magnitude=magnitude) for root in (left, right)]
            if slopes[0] * slopes[1] * sign < 0:
                raise UnfollowedError

    def _slope(self, root: SyntaxNode, span: Span, *, magnitude: bool) -> int:
        """Return whether an expression rises on a stretch (1), falls (-1), or does neither."""
        ends = [self._value(root, position) for position in span]
        if not all(isinstance(value, int | float) for value in ends):
            return 0
        if magnitude:
            ends = list(map(abs, ends))
        return _side(ends[1], ends[0])

    # ---- bisection ---------------------------------------------------------------------------

    def _value(self, root: SyntaxNode, position: int) -> Any:
        number = self._line.at(position)
        return evaluated(root, self._name, number, self.others)

    def _split_errors(self, root: SyntaxNode) -> None:
        """Split where an expression begins to raise errors: at the ends of stretches."""
        for first, last in self.spans:
            inside = next(
                (at for at in _probes(first, last) if self._value(root, at) is not FAILED), None
            )
            if inside is not None:
                for low, high in ((first, inside), (inside, last)):
                    self._bisect(low, high, lambda at: self._value(root, at) is FAILED)

    def _split(self, side: Callable[[int], Any]) -> None:
        """Split where a function that rises or falls on each stretch changes: twice at most."""
        for first, last in self.spans:
            begin: int | None = first
            while begin is not None:
                begin = self._bisect(begin, last, side)

    def _bisect(self, first: int, last: int, side: Callable[[int], Any]) -> int | None:
        """Split where a function is no longer what it is at the first position; return where."""
        before = side(first)
        if side(last) == before:
            return None
        low, high = first, last
        while high - low > 1:
            middle = (low + high) // 2
            if side(middle) == before:
                low = middle
            else:
                high = middle
        self._begins.add(high)
        return high


def _side(left: Any, right: Any) -> int:
    """Return -1, 0 or 1: a value is less than another, equal, or more; 2 where it is neither."""
    if all(isinstance(side, int | float) for side in (left, right)):
        return int(left > right) - int(left < right)
    return 0 if left == right else 2


def _probes(first: int, last: int) -> Iterator[int]:
    """Yield some positions of a stretch: its ends, those between, and those of round numbers."""
    yield first
    yield last
    for parts in (2, 4, 16):
        yield from (first + (last - first) * part // parts for part in range(1, parts))


def borders(spans: Iterable[Span], line: Line) -> list[float]:
    """Return the first number of each stretch but the first."""
    return [line.at(first) for first, _ in list(spans)[1:]]


def is_literal(root: SyntaxNode) -> bool:
    """Does an expression hold no name, and draw nothing?"""
    if isinstance(root, FunctionCall) and root.draws:
        return False
    return isinstance(root, Constant) or (bool(root.parts) and all(map(is_literal, root.parts)))
