"""From a formula to the operators that evaluate it while a mission runs."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias, cast

from bt_mission.language.expressions.syntax import (
    Arithmetic,
    Comparison,
    Constant,
    EvaluationScope,
    Logic,
    Negation,
    Not,
    SyntaxNode,
)
from bt_mission.language.expressions.values import ExpressionError, Plain
from bt_mission.language.requirements.formula import signals_in, walk
from bt_mission.language.requirements.signals import ENDS_WITH_MISSION, SIGNALS, Unit
from bt_mission.language.requirements.syntax import (
    FUTURE,
    Chain,
    SignalValue,
    Temporal,
)
from bt_mission.language.requirements.syntax import TimeWindow as WrittenWindow
from bt_mission.language.requirements.units import unit_of
from bt_mission.requirements.looking_ahead import Ahead, Future, LateCombined, Present, Until
from bt_mission.requirements.looking_back import (
    Atom,
    Combinator,
    Combined,
    Ever,
    Historically,
    Joint,
    Past,
    Since,
)
from bt_mission.requirements.roots import Answered, Kept, Root, RootJoint, Steady, Throughout, Up

Reader: TypeAlias = Callable[[], Plain | None]
"""Gives the present value of a signal; None while it has none. A number is never `nan`."""

Number: TypeAlias = Callable[[], float | None]


@dataclass
class Compiler:
    """Builds operators; `units` are those of the comparisons, by their numbers.

    Args:
        readers: Of every signal in the formula, by the text of the signal.
        bounds: What gives a lower bound of a signal, and costs less than its value.
    """

    readers: Mapping[str, Reader]
    bounds: Mapping[str, Number] = field(default_factory=dict)
    units: list[Unit | None] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    """Why a condition could not be evaluated: the first reason."""

    def root(self, node: SyntaxNode, *, positive: bool = True) -> Root:
        """Return a formula at the start of a run, or what it is where it does not hold."""
        match node:
            case Not(operand=operand):
                return self.root(operand, positive=not positive)
            case Logic(symbol=symbol, left=left, right=right):
                parts = [self.root(part, positive=positive) for part in (left, right)]
                return RootJoint(parts, all_of=(symbol == "and") is positive)
            case Temporal(word=word, operand=operand, window=window):
                all_of = (word == "always") is positive
                return self._throughout(operand, window, all_of=all_of, positive=positive)
            case Chain(left=left, right=right, window=window):
                first, second = (self._future(part, positive=positive) for part in (left, right))
                return Up(first, second, *_ns(window), dual=not positive)
        raise AssertionError("a formula was checked to speak of more than the start")

    def condition(self, node: SyntaxNode) -> Past:
        """Return a condition on the present and what was before."""
        return self._past(node, positive=True)

    def _throughout(
        self, operand: SyntaxNode, window: WrittenWindow, *, all_of: bool, positive: bool
    ) -> Root:
        """Return `always` or `eventually`, with what looks ahead turned round where it can be.

        A window ahead of each instant is one behind each later instant: so a violation is seen
        when it happens, and not when the window is over.
        """
        if all_of and window.is_everything:
            parts = _parts(operand, "and", positive=positive)
            if len(parts) > 1 and any(_looks_ahead(part) for part, _ in parts):
                roots = [
                    self._throughout(part, window, all_of=True, positive=sign)
                    for part, sign in parts
                ]
                return RootJoint(roots, all_of=True)
            answered = self._answered(operand, positive=positive)
            if answered is not None:
                return answered
        future = self._future(operand, positive=positive)
        if isinstance(future, Present):
            if window.is_everything and isinstance(future.past, Atom):
                return Steady(future.past, all_of=all_of)
            if all_of:
                return Kept(future.past, *_ns(window))
        return Throughout(future, *_ns(window), all_of=all_of)

    def _answered(self, operand: SyntaxNode, *, positive: bool) -> Root | None:
        """Return `always` of `x or eventually[a,b] y`, and of `x or always[0,b] y`.

        The latter is `historically[0,b] x or y`. None for another formula.
        """
        parts = _parts(operand, "or", positive=positive)
        ahead = [part for part in parts if _looks_ahead(part[0])]
        if len(ahead) != 1 or len(parts) == 1:
            return None
        node, sign = ahead[0]
        if not isinstance(node, Temporal) or _looks_ahead(node.operand):
            return None
        start, end = _ns(node.window)
        assert end is not None, "a window inside another formula was checked to end"
        is_always = (node.word == "always") is sign
        if node.word not in FUTURE or (is_always and start > 0):
            return None
        rest = [self._past(part, positive=sign) for part, sign in parts if (part, sign) != ahead[0]]
        answer = self._past(node.operand, positive=sign)
        if not is_always:
            return Answered(rest, answer, (start, end))
        either = Combined(rest, Joint(all_of=False))
        before = Combined([either], Historically((start, end), all_of=True))
        return Kept(Combined([before, answer], Joint(all_of=False)), 0, None)

    def _future(self, node: SyntaxNode, *, positive: bool) -> Future:
        if not _looks_ahead(node):
            return Present(self._past(node, positive=positive))
        match node:
            case Not(operand=operand):
                return self._future(operand, positive=not positive)
            case Temporal(word=word) | Chain(symbol=word) if word not in FUTURE:
                return self._late(node, positive=positive)
            case Logic():
                return self._late(node, positive=positive)
            case Temporal(word=word, operand=operand, window=window):
                start, end = _ns(window)
                assert end is not None, "a window inside another formula was checked to end"
                inner = self._future(operand, positive=positive)
                return Ahead(inner, start, end, all_of=(word == "always") is positive)
            case Chain(left=left, right=right, window=window):
                start, end = _ns(window)
                assert end is not None, "a window inside another formula was checked to end"
                first, second = (self._future(part, positive=positive) for part in (left, right))
                return Until(first, second, start, end, dual=not positive)
        raise AssertionError("what looks ahead is one of these")

    def _late(self, node: SyntaxNode, *, positive: bool) -> Future:
        parts = [self._future(part, positive=positive) for part in node.parts]
        return LateCombined(parts, _combinator(node, positive=positive))

    def _past(self, node: SyntaxNode, *, positive: bool) -> Past:
        match node:
            case Not(operand=operand):
                return self._past(operand, positive=not positive)
            case Temporal(word=word, operand=operand, window=window) if window.is_everything:
                inner = self._past(operand, positive=positive)
                return Ever(inner, all_of=(word == "historically") is positive)
            case Logic() | Temporal() | Chain():
                parts = [self._past(part, positive=positive) for part in node.parts]
                return Combined(parts, _combinator(node, positive=positive))
        return self._atom(node, positive=positive)

    # ---- comparisons ---------------------------------------------------------------------

    def _atom(self, node: SyntaxNode, *, positive: bool) -> Atom:
        margin, is_strict = self._margin(node, positive=positive)
        at_least = self._at_least(node, positive=positive)
        self.units.append(unit_of(node) if isinstance(node, Comparison) else None)
        ends = all(one.name in (*ENDS_WITH_MISSION, "$") for one in signals_in(node))
        return Atom(
            margin,
            len(self.units) - 1,
            is_strict=is_strict,
            is_settled_by_end=ends,
            at_least=at_least,
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

    def _margin(self, node: SyntaxNode, *, positive: bool) -> tuple[Number, bool]:
        """Return what gives the margin of a condition, and whether a margin of 0 fails."""
        if isinstance(node, Comparison) and len(node.rest) == 1:
            symbol, _, right = node.rest[0]
            first, second = self._number(node.first), self._number(right)
            if (symbol in ("<", "<=")) is positive:
                first, second = second, first
            margin = _difference(first, second)
            if symbol in ("<", "<=", ">", ">=") and margin is not None:
                return margin, (symbol in ("<", ">")) is positive
        margin = self._measured(node)
        return (margin, True) if positive else (_negative(margin), False)

    def _number(self, node: SyntaxNode) -> Number | float | None:
        """Return what gives a number, or the number; None where that takes a whole evaluation."""
        match node:
            case Constant(value=int() | float() as value):
                return float(value)
            case Negation(operand=Constant(value=int() | float() as value), sign=sign):
                return float(sign * value)
            case SignalValue(name=name) if name in SIGNALS:
                if SIGNALS[name].type not in ("number", "integer"):
                    return None
                return cast("Number", self.readers[node.key])
            case Arithmetic(symbol="-", left=left, right=right):
                return _difference(self._number(left), self._number(right))
        return None

    def _measured(self, node: SyntaxNode) -> Number:
        """Return what evaluates a condition of any form; truth without a measure is infinite."""
        if isinstance(node, SignalValue):
            return _truth(self.readers[node.key])
        readers = [(one.key, self.readers[one.key]) for one in signals_in(node)]
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


def _combinator(node: SyntaxNode, *, positive: bool) -> Combinator:
    """Return what `and`, `or`, and the words that look back, make of the values of their parts."""
    match node:
        case Logic(symbol=symbol):
            return Joint(all_of=(symbol == "and") is positive)
        case Temporal(word=word, window=window):
            return Historically(_ns(window), all_of=(word == "historically") is positive)
        case Chain(window=window):
            return Since(_ns(window), dual=not positive)
    raise AssertionError("what joins formulas is one of these")


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


def _ns(window: WrittenWindow) -> tuple[int, int | None]:
    return round(window.start * 1e9), round(window.end * 1e9) if window.is_bounded else None


def _looks_ahead(node: SyntaxNode) -> bool:
    return any(
        (isinstance(part, Temporal) and part.word in FUTURE)
        or (isinstance(part, Chain) and part.symbol in FUTURE)
        for part in walk(node)
    )


def _parts(node: SyntaxNode, symbol: str, *, positive: bool) -> list[tuple[SyntaxNode, bool]]:
    """Return the parts of an `and` or `or`, each with whether it holds or its negation does."""
    match node:
        case Not(operand=operand):
            return _parts(operand, symbol, positive=not positive)
        case Logic(symbol=found, left=left, right=right) if (found == symbol) is positive:
            return [
                *_parts(left, symbol, positive=positive),
                *_parts(right, symbol, positive=positive),
            ]
    return [(node, positive)]
