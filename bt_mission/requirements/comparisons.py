"""From a comparison of signals to what gives its margin while a mission runs."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias, cast

from bt_mission.core.units import Dimension
from bt_mission.language.expressions.syntax import (
    Arithmetic,
    Comparison,
    Constant,
    EvaluationScope,
    Negation,
    SyntaxNode,
)
from bt_mission.language.expressions.values import ExpressionError, Plain
from bt_mission.language.requirements.formula import signals_in
from bt_mission.language.requirements.signals import ENDS_WITH_MISSION, SIGNALS
from bt_mission.language.requirements.syntax import Measure, SignalValue
from bt_mission.language.requirements.units import unit_of
from bt_mission.requirements.looking_back import Atom, Monotone, Past

Reader: TypeAlias = Callable[[], Plain | None]
"""Gives the present value of a signal; None while it has none. A number is never `nan`."""

Number: TypeAlias = Callable[[], float | None]


@dataclass
class ComparisonCompiler:
    """Builds the atoms of formulas; `units` are those of the comparisons, by their numbers.

    Args:
        readers: Of every signal in the formula, by the text of the signal.
        bounds: What gives a lower bound of a signal, and costs less than its value.
    """

    readers: Mapping[str, Reader]
    bounds: Mapping[str, Number] = field(default_factory=dict)
    units: list[Dimension | None] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    """Why a condition could not be evaluated: the first reason."""

    def atom(self, node: SyntaxNode, *, positive: bool) -> Past:
        """Return a condition without words of time, or its negation."""
        margin, is_strict, of = self._margin(node, positive=positive)
        at_least = self._at_least(node, positive=positive)
        self.units.append(unit_of(node) if isinstance(node, Comparison) else None)
        ends = all(one.name in (*ENDS_WITH_MISSION, "$") for one in signals_in(node))
        return Atom(
            margin,
            len(self.units) - 1,
            is_strict=is_strict,
            is_settled_by_end=ends,
            at_least=at_least,
            of=of,
        )

    def _at_least(self, node: SyntaxNode, *, positive: bool) -> Number | None:
        """Return what gives a lower bound of the margin of `signal > number`, if cheap."""
        match node:
            case Comparison(first=SignalValue(key=key), rest=((symbol, _, right),)):
                bound, limit = self.bounds.get(key), self._number(right)
                is_floor = (symbol in (">", ">=")) if positive else (symbol in ("<", "<="))
                if bound is not None and isinstance(limit, float) and is_floor:
                    return _less(bound, limit)
        return None

    def _margin(self, node: SyntaxNode, *, positive: bool) -> tuple[Number, bool, Monotone | None]:
        """Return what gives the margin of a condition, whether 0 fails, and what alone decides."""
        if isinstance(node, Comparison) and len(node.rest) == 1:
            symbol, _, right = node.rest[0]
            first, second = self._number(node.first), self._number(right)
            rises = (symbol in (">", ">=")) is positive
            if not rises:
                first, second = second, first
            margin = _difference(first, second)
            if symbol in ("<", "<=", ">", ">=") and margin is not None:
                of = self._decisive(node.first, right, rises=rises)
                return margin, (symbol in ("<", ">")) is positive, of
        of = Monotone(self.readers[node.key], positive) if isinstance(node, SignalValue) else None
        margin = self._measured(node)
        return (margin, True, of) if positive else (_negative(margin), False, of)

    def _decisive(self, left: SyntaxNode, right: SyntaxNode, *, rises: bool) -> Monotone | None:
        """Return the signal of a comparison with a number; None for any other comparison."""
        limit, other = self._number(right), self._number(left)
        if isinstance(left, SignalValue) and isinstance(limit, float):
            return Monotone(self.readers[left.key], rises, limit)
        if isinstance(right, SignalValue) and isinstance(other, float):
            return Monotone(self.readers[right.key], not rises, other)
        return None

    def _number(self, node: SyntaxNode) -> Number | float | None:
        """Return what gives a number, or the number; None where that takes a whole evaluation."""
        match node:
            case Constant(value=int() | float() as value):
                return float(value)
            case Negation(operand=Constant(value=int() | float() as value), sign=sign):
                return float(sign * value)
            case Measure() if node.word != "value":
                return cast("Number", self.readers[node.key])
            case SignalValue(name=name) if name in SIGNALS:
                if SIGNALS[name].type not in ("number", "integer"):
                    return None
                return cast("Number", self.readers[node.key])
            case Arithmetic(symbol="-", left=left, right=right):
                return _difference(self._number(left), self._number(right))
        return None

    def reader_of(self, node: SyntaxNode) -> Reader:
        """Return what evaluates an expression; None where it has no value."""
        simple = self._number(node)
        if simple is not None and not isinstance(simple, float):
            return simple
        readers = [(one.key, self.readers[one.key]) for one in values_in(node)]
        draw = random.Random(0)  # never drawn from

        def value() -> Plain | None:
            fields = {key: read() for key, read in readers}
            known = {key: one for key, one in fields.items() if one is not None}
            if len(known) < len(fields):
                return None
            try:
                return node.evaluate(EvaluationScope({}, known, draw))
            except ExpressionError as error:
                if not self.problems:
                    self.problems.append(error.message)
                return None

        return value

    def _measured(self, node: SyntaxNode) -> Number:
        """Return what evaluates a condition of any form; truth without a measure is infinite."""
        if isinstance(node, SignalValue):
            return _truth(self.readers[node.key])
        readers = [(one.key, self.readers[one.key]) for one in values_in(node)]
        problems = self.problems
        draw = random.Random(0)  # never drawn from: the parser refuses what would

        def margin() -> float | None:
            fields: dict[str, Plain] = {}
            for key, read in readers:
                value = read()
                if value is None or (isinstance(value, float) and math.isnan(value)):
                    return None
                fields[key] = value
            try:
                return _margin_in(node, EvaluationScope({}, fields, draw))
            except ExpressionError as error:
                if not problems:
                    problems.append(error.message)
                return None

        return margin


def values_in(node: SyntaxNode) -> Iterator[SignalValue | Measure]:
    """Yield the signals and the measures of a condition, but none of what is inside a measure."""
    if isinstance(node, SignalValue | Measure):
        yield node
        return
    for part in node.parts:
        yield from values_in(part)


def _margin_in(node: SyntaxNode, scope: EvaluationScope) -> float:
    """Return the margin of a condition; 0 fails."""
    if not isinstance(node, Comparison):
        return math.inf if node.need(scope, "bool") else -math.inf
    is_true = node.evaluate(scope)
    margins = []
    left = node.first.evaluate(scope)
    for symbol, _, part in node.rest:
        right = part.evaluate(scope)
        margins.append(_gap(symbol, left, right))
        left = right
    margin = min(margins)
    if is_true:
        return margin if margin > 0 else math.ulp(0.0)
    return min(margin, 0.0)


def _gap(symbol: str, left: Plain, right: Plain) -> float:
    if isinstance(left, int | float) and isinstance(right, int | float):
        is_number = not isinstance(left, bool)
        if is_number and symbol in ("<", "<="):
            return float(right - left)
        if is_number and symbol in (">", ">="):
            return float(left - right)
        if is_number:
            return float(abs(left - right)) * (1 if symbol == "!=" else -1)
    return math.inf if (left == right) is (symbol == "==") else -math.inf


def _difference(first: Number | float | None, second: Number | float | None) -> Number | None:
    """Return what gives `first - second`; None where one is not a number as simple as that."""
    if first is None or second is None:
        return None
    if isinstance(second, float):
        return None if isinstance(first, float) else _less(first, second)
    if isinstance(first, float):
        return _beyond(first, second)
    one, other = first, second

    def between() -> float | None:
        left, right = one(), other()
        return None if left is None or right is None else left - right

    return between


def _less(read: Number, limit: float) -> Number:
    def less() -> float | None:
        value = read()
        return None if value is None else value - limit

    return less


def _beyond(limit: float, read: Number) -> Number:
    def beyond() -> float | None:
        value = read()
        return None if value is None else limit - value

    return beyond


def _truth(read: Reader) -> Number:
    def truth() -> float | None:
        value = read()
        return None if value is None else (math.inf if value else -math.inf)

    return truth


def _negative(margin: Number) -> Number:
    def negated() -> float | None:
        value = margin()
        return None if value is None else -value

    return negated
