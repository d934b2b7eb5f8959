"""The parts of a requirement that expressions do not have: signals, and time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

from typing_extensions import override

from bt_mission.language.expressions.syntax import EvaluationScope, Logic, Not, SyntaxNode, Types
from bt_mission.language.expressions.values import ExpressionError, Plain, Type
from bt_mission.requirements.language.signals import SIGNALS


@dataclass(frozen=True)
class TimeWindow:
    """An interval of time, s, after or before the present instant; both ends belong to it.

    Attributes:
        so_far: Of a window that looks back: does the part within the run count before it is full?
    """

    start: float = 0.0
    end: float = math.inf
    so_far: bool = False

    @property
    def is_bounded(self) -> bool:
        """Does it end?"""
        return self.end < math.inf


EVERYTHING = TimeWindow()
"""Every instant from now on, or until now."""


@dataclass(frozen=True)
class SignalValue(SyntaxNode):
    """A signal: `clearance`, `age("scan")`; or, as `$name`, a variable (the name is `$`)."""

    name: str
    arguments: tuple[str, ...] = ()

    @cached_property
    def key(self) -> str:
        """The signal as it is written; the same for two that are the same."""
        if self.name == "$":
            return f"${self.arguments[0]}"
        if not self.arguments:
            return self.name
        return f"{self.name}({', '.join(map(repr, self.arguments))})"

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        if self.key not in scope.fields:
            raise ExpressionError("BT-410", f"'{self.key}' has no value", self.column)
        return scope.fields[self.key]

    @override
    def infer(self, types: Types) -> Type | None:
        return SIGNALS[self.name].type if self.name in SIGNALS else None


@dataclass(frozen=True)
class Implies(Logic):
    """`a implies b`, and what `whenever` has at each instant: `not a or b`.

    Attributes:
        premise: The text of `a`.
    """

    premise: str

    @classmethod
    def of(cls, left: SyntaxNode, right: SyntaxNode, premise: str) -> Implies:
        """Return that the left side implies the right one."""
        return cls(left.column, "or", Not(left.column, left), right, premise)


FUTURE = frozenset(("always", "eventually", "until"))
EDGES = ("starts", "ends")


@dataclass(frozen=True)
class Temporal(SyntaxNode):
    """A formula about other instants than the present one.

    Attributes:
        word: One of `FUTURE` and `EDGES`, or `historically`, `previously` or `since`.
        operands: Two of `until` and `since`, one of the others.
        window: After the present instant, or before it.
    """

    word: str
    operands: tuple[SyntaxNode, ...]
    window: TimeWindow = EVERYTHING

    @property
    @override
    def parts(self) -> tuple[SyntaxNode, ...]:
        return self.operands

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        raise ExpressionError("BT-604", f"'{self.word}' covers more than one instant", self.column)

    @override
    def infer(self, types: Types) -> Type | None:
        for operand in self.operands:
            operand.expect(types, "bool")
        return "bool"


@dataclass(frozen=True)
class Measure(SyntaxNode):
    """A number computed from the past: the count of an edge, the mean of a number, ...

    Attributes:
        word: `count`, `mean`, `rate` or `value`.
        operand: What is measured; None for a count.
        edge: What is counted, or at the last of which the value is taken.
        window: Before the present instant.
    """

    word: str
    operand: SyntaxNode | None
    edge: Temporal | None
    window: TimeWindow

    @property
    @override
    def parts(self) -> tuple[SyntaxNode, ...]:
        return tuple(bound for bound in (self.operand, self.edge) if bound is not None)

    @cached_property
    def key(self) -> str:
        """The name of its value among the fields of an evaluation."""
        return repr(self)

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        return scope.fields[self.key]

    @override
    def infer(self, types: Types) -> Type | None:
        if self.edge is not None:
            self.edge.infer(types)
        if self.operand is None:
            return "integer"
        if self.word == "value":
            return self.operand.infer(types)
        self.operand.expect(types, "number")
        return "number"
