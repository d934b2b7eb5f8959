"""From a formula to the operators that evaluate it while a mission runs."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import TypeAlias, cast

from bt_mission.base.stamps import NS
from bt_mission.base.units import shown_unit
from bt_mission.language.expressions.syntax import (
    Comparison,
    EvaluationScope,
    Logic,
    Not,
    SyntaxNode,
)
from bt_mission.language.expressions.values import ExpressionError, Plain
from bt_mission.requirements.language.formula import (
    filling,
    full_after,
    looks_ahead,
    signals_in,
    unit_of,
    walk,
)
from bt_mission.requirements.language.signals import ENDS_WITH_MISSION
from bt_mission.requirements.language.syntax import (
    EVERYTHING,
    Measure,
    SignalValue,
    Temporal,
    TimeWindow,
)
from bt_mission.requirements.measures import MEASURED_VALUES, MeasuredCondition, MeasuredValue
from bt_mission.requirements.operators import (
    Ahead,
    Atom,
    CompiledFormula,
    Edge,
    Historically,
    Joint,
    Since,
    Until,
    Window,
)
from bt_mission.requirements.roots import JointRoot, Lasting, Response, Root, Throughout, UntilRoot

Reader: TypeAlias = Callable[[], Plain | None]
"""Gives the present value of a signal; None while it has none."""

Number: TypeAlias = Callable[[], float | None]


@dataclass
class Compiler:
    """Builds the operators of formulas.

    Args:
        readers: Of every signal in the formula, by the text of the signal.
        bounds: Give lower bounds of signals at less cost than their values.

    Attributes:
        units: The units of the comparisons, by their numbers.
        problems: Why a condition could not be evaluated: the first reason.
    """

    readers: dict[str, Reader]
    bounds: dict[str, Number] = field(default_factory=dict)
    units: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)

    # ---- formulas at the start -----------------------------------------------------------

    def root(self, node: SyntaxNode, *, positive: bool = True) -> Root:
        """Return a formula at the start of a run, or its negation."""
        match node:
            case Not(operand=operand):
                return self.root(operand, positive=not positive)
            case Logic(symbol=symbol):
                parts = [self.root(part, positive=positive) for part in node.parts]
                return JointRoot(parts, all_of=(symbol == "and") is positive)
            case Temporal(word="until", window=window):
                sides = self._parts(node, positive=positive)
                return UntilRoot(sides, _ns(window), all_of=not positive)
            case Temporal(word=word, operands=(operand,), window=window):
                all_of = (word == "always") is positive
                return self._throughout(operand, window, all_of=all_of, positive=positive)
        raise AssertionError("a formula was checked to be about more than the start")

    def _throughout(
        self, operand: SyntaxNode, window: TimeWindow, *, all_of: bool, positive: bool
    ) -> Root:
        """Return `always` or `eventually`.

        Where it can, a violation is noticed when it happens and not when its window is over: each
        part of an `and` is evaluated alone, and `always` ahead of each instant becomes
        `historically` behind each later instant.
        """
        if all_of and window == EVERYTHING:
            parts = _split(operand, "and", positive=positive)
            has_value = not full_after(operand)  # where a part has none, neither has the whole
            if len(parts) > 1 and has_value and any(map(looks_ahead, parts)):
                roots = [
                    self._throughout(part, window, all_of=True, positive=True) for part in parts
                ]
                return JointRoot(roots, all_of=True)
            response = _response(operand, positive=positive)
            if response is not None:
                return self._response(*response)
        return Throughout(self.formula(operand, positive=positive), _ns(window), all_of=all_of)

    def _response(self, before: SyntaxNode, answer: Temporal) -> Root:
        """Return `always (before or answer)`, of which only the answer looks ahead.

        `x or always[0,b] y` at every instant is `historically[0,b] x or y` at every instant.
        """
        (then,), window = answer.operands, answer.window
        if answer.word == "eventually":
            ahead = Ahead([self.formula(then)], _ns(window), all_of=False)
            return Response(self.formula(before), ahead)
        past = Temporal(answer.column, "historically", (before,), replace(window, so_far=True))
        turned = self.formula(Logic(answer.column, "or", past, then))
        is_settled = self.formula(then).is_settled_by_end
        return Lasting(turned, self.formula(before), _ns(window)[1], is_settled_by_end=is_settled)

    # ---- formulas at every instant -------------------------------------------------------

    def formula(self, node: SyntaxNode, *, positive: bool = True) -> CompiledFormula:
        """Return a formula at every instant, or its negation."""
        match node:
            case Not(operand=operand):
                return self.formula(operand, positive=not positive)
            case Temporal(word="starts" | "ends" as word, operands=(operand,)):
                return Edge(self.formula(operand), ends=word == "ends", positive=positive)
            case Temporal():
                return self._temporal(node, positive=positive)
            case Logic(symbol=symbol):
                parts = self._parts(node, positive=positive)
                return Joint(parts, all_of=(symbol == "and") is positive)
        return self._atom(node, positive=positive)

    def _temporal(self, node: Temporal, *, positive: bool) -> CompiledFormula:
        parts, window = self._parts(node, positive=positive), _ns(node.window)
        full_ns = round(full_after(node) * NS) if filling(node) else 0
        match node.word:
            case "until":
                return Until(parts, window, all_of=not positive)
            case "since":
                return Since(parts, window, full_ns=full_ns, dual=not positive)
            case "always" | "eventually" as word:
                return Ahead(parts, window, all_of=(word == "always") is positive)
        all_of = (node.word == "historically") is positive
        return Historically(parts, window, full_ns=full_ns, all_of=all_of)

    def _parts(self, node: SyntaxNode, *, positive: bool) -> list[CompiledFormula]:
        return [self.formula(part, positive=positive) for part in node.parts]

    def _atom(self, node: SyntaxNode, *, positive: bool) -> CompiledFormula:
        """Return a condition without words of time, or its negation; measures may be in it."""
        measures: dict[str, MeasuredValue] = {}
        for measure in values_in(node):
            if isinstance(measure, Measure):
                self._add_measure(measure, measures)
        margin, is_strict = self._margin(node, positive=positive)
        self.units.append(shown_unit(unit_of(node)) if isinstance(node, Comparison) else "")
        atom = Atom(
            margin,
            len(self.units) - 1,
            is_strict=is_strict,
            is_settled_by_end=all(
                signal.name in (*ENDS_WITH_MISSION, "$") for signal in signals_in(node)
            ),
            lower_bound=self._lower_bound(node, positive=positive),
        )
        if not measures:
            return atom
        inner = [part for part in walk(node) if isinstance(part, Measure)]
        moves = any(part.word in ("mean", "rate") or part.window.is_bounded for part in inner)
        return MeasuredCondition(atom, tuple(measures.values()), moves=moves)

    def _add_measure(self, node: Measure, measures: dict[str, MeasuredValue]) -> None:
        """Add a measure, after those inside it, and a reader of its value by its key."""
        if node.key in measures:
            return
        for inner in values_in(node.operand) if node.operand is not None else ():
            if isinstance(inner, Measure):
                self._add_measure(inner, measures)
        measure = MEASURED_VALUES[node.word](
            (lambda: None) if node.operand is None else self._value_of(node.operand),
            None if node.edge is None else self.formula(node.edge),
            window_ns=_ns(node.window)[1],
            full_ns=round(full_after(node) * NS) if filling(node) else 0,
        )
        measures[node.key] = measure
        self.readers = {**self.readers, node.key: lambda: measure.value}

    # ---- comparisons ---------------------------------------------------------------------

    def _margin(self, node: SyntaxNode, *, positive: bool) -> tuple[Number, bool]:
        """Return what gives the margin of a condition, and whether a margin of 0 is false."""
        match node:
            case Comparison(first=first, rest=(("<" | "<=" | ">" | ">=" as symbol, _, second),)):
                types = [side.infer(lambda _: None) for side in (first, second)]
                if all(kind in ("number", "integer") for kind in types):
                    rises = (symbol in (">", ">=")) is positive
                    left, right = (first, second) if rises else (second, first)
                    margin = _difference(self._value_of(left), self._value_of(right))
                    return margin, (symbol in ("<", ">")) is positive
        margin = cast("Number", self._evaluated(node, _margin_in))
        return (margin, True) if positive else (_negative(margin), False)

    def _lower_bound(self, node: SyntaxNode, *, positive: bool) -> Number | None:
        """Return what gives a lower bound of the margin of `signal > number`, if one is cheap."""
        match node:
            case Comparison(first=SignalValue(key=key), rest=((symbol, _, second),)):
                is_floor = symbol in ((">", ">=") if positive else ("<", "<="))
                if key in self.bounds and is_floor and not any(values_in(second)):
                    return _difference(self.bounds[key], self._value_of(second))
        return None

    def _value_of(self, node: SyntaxNode) -> Reader:
        """Return what evaluates an expression; None where it has no value."""
        if isinstance(node, SignalValue | Measure):
            return self.readers[node.key]
        evaluated = self._evaluated(node, lambda node, scope: node.evaluate(scope))
        if any(values_in(node)):
            return evaluated
        value = evaluated()
        constant = float(value) if type(value) is int else value
        return lambda: constant

    def _evaluated(
        self, node: SyntaxNode, evaluate: Callable[[SyntaxNode, EvaluationScope], Plain]
    ) -> Reader:
        """Return what evaluates a part of a formula; None where a signal in it has no value."""
        readers = [(signal.key, self.readers[signal.key]) for signal in values_in(node)]
        problems = self.problems
        fields: dict[str, Plain] = {}
        scope = EvaluationScope({}, fields, random.Random(0))  # the parser refuses what draws

        def value() -> Plain | None:
            for key, read in readers:
                reading = read()
                if reading is None or (isinstance(reading, float) and math.isnan(reading)):
                    return None
                fields[key] = reading
            try:
                return evaluate(node, scope)
            except ExpressionError as error:
                if not problems:
                    problems.append(error.message)
                return None

        return value


def values_in(node: SyntaxNode) -> Iterator[SignalValue | Measure]:
    """Yield the signals and the measures of a condition, but none of what is inside a measure."""
    if isinstance(node, SignalValue | Measure):
        yield node
        return
    for part in node.parts:
        yield from values_in(part)


def _split(node: SyntaxNode, symbol: str, *, positive: bool) -> list[SyntaxNode]:
    """Return the parts of an `and` or `or`, or of what its negation is; each may be negated."""
    match node:
        case Not(operand=operand):
            return _split(operand, symbol, positive=not positive)
        case Logic(symbol=joining) if (joining == symbol) is positive:
            return [
                piece for part in node.parts for piece in _split(part, symbol, positive=positive)
            ]
    return [node if positive else Not(node.column, node)]


def _response(operand: SyntaxNode, *, positive: bool) -> tuple[SyntaxNode, Temporal] | None:
    """Return the parts of `x or eventually[a,b] y` and `x or always[0,b] y`, x and y of the past.

    The second part is `eventually` or `always`, not negated. None for another formula.
    """
    parts = _split(operand, "or", positive=positive)
    ahead = [part for part in parts if looks_ahead(part)]
    rest = [part for part in parts if not looks_ahead(part)]
    if len(ahead) != 1 or not rest:
        return None
    answer = ahead[0]
    match answer:
        case Not(operand=Temporal(word="always" | "eventually" as word, operands=(then,)) as node):
            dual = "always" if word == "eventually" else "eventually"
            answer = Temporal(node.column, dual, (Not(then.column, then),), node.window)
    match answer:
        case Temporal(word="always" | "eventually" as word, operands=(then,), window=window):
            if not looks_ahead(then) and (word == "eventually" or window.start == 0):
                before = reduce(lambda left, right: Logic(left.column, "or", left, right), rest)
                return before, answer
    return None


def _ns(window: TimeWindow) -> Window:
    return round(window.start * NS), round(window.end * NS) if window.is_bounded else math.inf


def _margin_in(node: SyntaxNode, scope: EvaluationScope) -> float:
    """Return the margin of a condition, which is false at 0; truth without one is infinite."""
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


def _difference(minuend: Reader, subtrahend: Reader) -> Number:
    """Return what gives the difference of two numbers; None where one has no value."""
    read, read_limit = cast("Number", minuend), cast("Number", subtrahend)

    def difference() -> float | None:
        value, limit = read(), read_limit()
        return None if value is None or limit is None else value - limit

    return difference


def _negative(margin: Number) -> Number:
    def negated() -> float | None:
        value = margin()
        return None if value is None else -value

    return negated
