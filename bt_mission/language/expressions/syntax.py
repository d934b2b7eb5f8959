"""The parts of an expression: each can be evaluated, and can tell its type beforehand.

The rules are Python's, made stricter: no arithmetic on truth values or text, no comparison of
different types, `and`, `or` and `not` on truth values only.
"""

from __future__ import annotations

import math
import operator
import random
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from typing_extensions import override

from bt_mission.base.diagnostics import did_you_mean, listed
from bt_mission.language.expressions.functions import FUNCTIONS, result_type
from bt_mission.language.expressions.values import (
    MAX_MAGNITUDE,
    WORDS,
    ExpressionError,
    NoValue,
    Plain,
    Type,
    bounded,
    fits,
    joined,
    mismatch,
    type_of,
)

Types = Callable[["Name"], Type | None]
"""The type of a name; None where it is not known."""


class EvaluationScope(NamedTuple):
    """What names mean in one evaluation: variables, and the fields that come before them."""

    variables: Mapping[str, Plain | NoValue]
    fields: Mapping[str, Plain]
    draw: random.Random


@dataclass(frozen=True)
class SyntaxNode(ABC):
    """A part of an expression, and its column in the text (from 1)."""

    column: int

    @property
    def parts(self) -> tuple[SyntaxNode, ...]:
        """The parts directly inside this one."""
        return ()

    @abstractmethod
    def evaluate(self, scope: EvaluationScope) -> Plain:
        """Return the value. Raises ExpressionError."""

    @abstractmethod
    def infer(self, types: Types) -> Type | None:
        """Return the type, None where it is not known. Raises ExpressionError on a clash."""

    def need(self, scope: EvaluationScope, wanted: Type) -> Any:
        """Evaluate to a value of one type."""
        value = self.evaluate(scope)
        if not fits(type_of(value), wanted) or type_of(value) is None:
            raise mismatch(value, wanted, self.column)
        return value

    def expect(self, types: Types, wanted: Type) -> Type | None:
        """Infer a type, which must fit."""
        kind = self.infer(types)
        if not fits(kind, wanted):
            raise ExpressionError(
                "BT-404", f"expected {WORDS[wanted]}, got {WORDS[kind]}", self.column
            )
        return kind


@dataclass(frozen=True)
class Constant(SyntaxNode):
    """A number, a text, true, false, or pi."""

    value: Plain

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        return self.value

    @override
    def infer(self, types: Types) -> Type | None:
        return type_of(self.value)


@dataclass(frozen=True)
class Name(SyntaxNode):
    """A name: `$x` (a variable), or `x` and `x.y` (a field first, else a variable)."""

    name: str
    variable: bool

    @property
    def shown(self) -> str:
        """The name as written in the text."""
        return f"${self.name}" if self.variable else self.name

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        if not self.variable and self.name in scope.fields:
            return scope.fields[self.name]
        if self.name in scope.variables:
            value = scope.variables[self.name]
            if isinstance(value, NoValue):
                raise ExpressionError(
                    "BT-410", f"'{self.shown}' has no value: {value.reason}", self.column
                )
            return value
        known = [*scope.variables, *(() if self.variable else scope.fields)]
        message = f"'{self.shown}' has no value (values: {listed(known)})"
        raise ExpressionError("BT-410", message, self.column, did_you_mean(self.name, known))

    @override
    def infer(self, types: Types) -> Type | None:
        return types(self)


@dataclass(frozen=True)
class Unary(SyntaxNode):
    """A computation with one operand."""

    operand: SyntaxNode

    @property
    @override
    def parts(self) -> tuple[SyntaxNode, ...]:
        return (self.operand,)


@dataclass(frozen=True)
class Binary(SyntaxNode):
    """Two parts with a symbol or word between them."""

    symbol: str
    left: SyntaxNode
    right: SyntaxNode

    @property
    @override
    def parts(self) -> tuple[SyntaxNode, ...]:
        return self.left, self.right


@dataclass(frozen=True)
class Negation(Unary):
    """-x or +x."""

    sign: int

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        value: float = self.operand.need(scope, "number")
        return -value if self.sign < 0 else value

    @override
    def infer(self, types: Types) -> Type | None:
        return self.operand.expect(types, "number")


@dataclass(frozen=True)
class Arithmetic(Binary):
    """Two numbers and one of + - * / // % **."""

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        left = self.left.need(scope, "number")
        right = self.right.need(scope, "number")
        was_finite = math.isfinite(left) and math.isfinite(right)
        try:
            if self.symbol == "**":
                _refuse_large_power(left, right, self.column)
            value = _ARITHMETIC[self.symbol](left, right)
        except ZeroDivisionError:
            raise ExpressionError("BT-406", "division by zero", self.column) from None
        except OverflowError:
            raise ExpressionError("BT-406", "the result is too large", self.column) from None
        if isinstance(value, complex):
            raise ExpressionError("BT-406", "the result is not a number", self.column)
        return bounded(value, self.column, was_finite=was_finite)

    @override
    def infer(self, types: Types) -> Type | None:
        left = self.left.expect(types, "number")
        right = self.right.expect(types, "number")
        if self.symbol == "/" or "number" in (left, right):
            return "number"
        if self.symbol == "**":
            whole = isinstance(self.right, Constant) and left == right == "integer"
            return "integer" if whole else None
        return "integer" if left == right == "integer" else None


@dataclass(frozen=True)
class Comparison(SyntaxNode):
    """a < b, or a chain as in Python: 0 < a <= 3."""

    first: SyntaxNode
    rest: tuple[tuple[str, int, SyntaxNode], ...]

    @property
    @override
    def parts(self) -> tuple[SyntaxNode, ...]:
        return (self.first, *(node for _, _, node in self.rest))

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        left = self.first.evaluate(scope)
        for symbol, column, node in self.rest:
            right = node.evaluate(scope)
            _refuse_comparison(type_of(left), type_of(right), symbol, column)
            if not _COMPARISON[symbol](left, right):
                return False
            left = right
        return True

    @override
    def infer(self, types: Types) -> Type | None:
        left = self.first.infer(types)
        for symbol, column, node in self.rest:
            right = node.infer(types)
            if left is not None and right is not None:
                _refuse_comparison(left, right, symbol, column)
            left = right
        return "bool"


@dataclass(frozen=True)
class Logic(Binary):
    """a and b, a or b; the second is looked at only where it matters."""

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        left: bool = self.left.need(scope, "bool")
        if left == (self.symbol == "or"):
            return left
        right: bool = self.right.need(scope, "bool")
        return right

    @override
    def infer(self, types: Types) -> Type | None:
        self.left.expect(types, "bool")
        self.right.expect(types, "bool")
        return "bool"


@dataclass(frozen=True)
class Not(Unary):
    """not a."""

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        return not self.operand.need(scope, "bool")

    @override
    def infer(self, types: Types) -> Type | None:
        self.operand.expect(types, "bool")
        return "bool"


@dataclass(frozen=True)
class FunctionCall(SyntaxNode):
    """A call of one of the known functions, with a number of arguments it takes."""

    name: str
    arguments: tuple[SyntaxNode, ...]
    draws: bool

    @property
    @override
    def parts(self) -> tuple[SyntaxNode, ...]:
        return self.arguments

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        function = FUNCTIONS[self.name]
        wanted = function.takes
        values = [
            argument.evaluate(scope) if wanted is None else argument.need(scope, wanted)
            for argument in self.arguments
        ]
        numbers = [value for value in values if isinstance(value, int | float)]
        was_finite = all(math.isfinite(number) for number in numbers)
        try:
            value = function.apply(*([scope.draw] if self.draws else []), *values)
        except (ValueError, OverflowError) as error:
            reason = str(error) if "math" not in str(error) else "the result is not a number"
            raise ExpressionError("BT-406", f"{self.name}: {reason}", self.column) from None
        if isinstance(value, int | float):
            return bounded(value, self.column, was_finite=was_finite)
        return value

    @override
    def infer(self, types: Types) -> Type | None:
        wanted = FUNCTIONS[self.name].takes
        argument_types = [
            argument.infer(types) if wanted is None else argument.expect(types, wanted)
            for argument in self.arguments
        ]
        return result_type(self.name, argument_types)


@dataclass(frozen=True)
class Conditional(SyntaxNode):
    """a if condition else b; only the value that is selected is evaluated."""

    condition: SyntaxNode
    value: SyntaxNode
    otherwise: SyntaxNode

    @property
    @override
    def parts(self) -> tuple[SyntaxNode, ...]:
        return self.value, self.condition, self.otherwise

    def selected(self, scope: EvaluationScope) -> SyntaxNode:
        """Return the part whose value counts. Raises ExpressionError."""
        return self.value if self.condition.need(scope, "bool") else self.otherwise

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        return self.selected(scope).evaluate(scope)

    @override
    def infer(self, types: Types) -> Type | None:
        self.condition.expect(types, "bool")
        value, otherwise = self.value.infer(types), self.otherwise.infer(types)
        if value is None or otherwise is None:
            return None
        if not fits(value, otherwise) and not fits(otherwise, value):
            message = (
                f"the values of 'if' have different types: {WORDS[value]} and {WORDS[otherwise]}"
            )
            raise ExpressionError("BT-404", message, self.column)
        return joined((value, otherwise))


@dataclass(frozen=True)
class Subscript(SyntaxNode):
    """list[index], from the front or, below zero, from the back."""

    sequence: SyntaxNode
    index: SyntaxNode

    @property
    @override
    def parts(self) -> tuple[SyntaxNode, ...]:
        return self.sequence, self.index

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        values: list[Plain] = self.sequence.need(scope, "list")
        index: int = self.index.need(scope, "integer")
        if not -len(values) <= index < len(values):
            message = f"the list has {len(values)} elements, none at {index}"
            raise ExpressionError(
                "BT-406", message, self.index.column, "the first index is 0, the last is -1"
            )
        return values[index]

    @override
    def infer(self, types: Types) -> Type | None:
        self.sequence.expect(types, "list")
        self.index.expect(types, "integer")
        return None


_ARITHMETIC: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "//": operator.floordiv,
    "%": operator.mod,
    "**": operator.pow,
}
_COMPARISON: dict[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


def _refuse_large_power(base: float, exponent: float, column: int) -> None:
    """Refuse an integer power that would take long to compute, before it is computed."""
    whole = isinstance(base, int) and isinstance(exponent, int)
    grows = whole and exponent > 0 and abs(base) > 1
    if grows and exponent * math.log2(abs(base)) > math.log2(MAX_MAGNITUDE) + 1:
        raise ExpressionError("BT-406", "the result is too large", column)


def _refuse_comparison(left: Type | None, right: Type | None, symbol: str, column: int) -> None:
    if left == right and (left in ("integer", "number") or symbol in ("==", "!=")):
        return
    sides = {"number" if side == "integer" else side for side in (left, right)}
    if len(sides) > 1:
        message = f"cannot compare {WORDS[left]} with {WORDS[right]}"
        raise ExpressionError("BT-404", message, column)
    if symbol not in ("==", "!=") and sides != {"number"}:
        raise ExpressionError("BT-404", f"'{symbol}' compares numbers, got {WORDS[left]}", column)
