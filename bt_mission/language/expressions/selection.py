"""The parts of an expression that select: one of two values, an element of a list."""

from __future__ import annotations

from dataclasses import dataclass

from typing_extensions import override

from bt_mission.language.expressions.syntax import EvaluationScope, SyntaxNode, Types
from bt_mission.language.expressions.values import (
    WORDS,
    ExpressionError,
    Plain,
    Type,
    fits,
    joined,
)


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
            message = f"one value of 'if' is {WORDS[value]}, the other one {WORDS[otherwise]}"
            raise ExpressionError(message, self.column)
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
            raise ExpressionError(message, self.index.column, "the first one is 0, the last one -1")
        return values[index]

    @override
    def infer(self, types: Types) -> Type | None:
        self.sequence.expect(types, "list")
        self.index.expect(types, "integer")
        return None
