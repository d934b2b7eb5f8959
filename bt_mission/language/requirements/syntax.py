"""The parts of a requirement that expressions do not have: signals, quantities, and time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

from typing_extensions import override

from bt_mission.language.expressions.syntax import (
    Binary,
    EvaluationScope,
    SyntaxNode,
    Types,
    Unary,
)
from bt_mission.language.expressions.values import ExpressionError, Plain, Type
from bt_mission.language.requirements.signals import SIGNALS


@dataclass(frozen=True)
class TimeWindow:
    """An interval of time, s, after or before the present instant; both ends belong to it.

    Attributes:
        so_far: Has one that looks back a value before it is full: of the part within the run?
    """

    start: float = 0.0
    end: float = math.inf
    so_far: bool = False

    @property
    def is_bounded(self) -> bool:
        """Does it end?"""
        return self.end < math.inf

    @property
    def is_everything(self) -> bool:
        """Does it hold every instant from now on, or until now?"""
        return self == EVERYTHING


EVERYTHING = TimeWindow()


@dataclass(frozen=True)
class SignalValue(SyntaxNode):
    """A signal: `clearance`, `age("scan")`; or, as `$name`, a variable (the name is `$`)."""

    name: str
    arguments: tuple[str, ...] = ()

    @property
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
            raise ExpressionError(f"'{self.key}' has no value", self.column)
        return scope.fields[self.key]

    @override
    def infer(self, types: Types) -> Type | None:
        return SIGNALS[self.name].type if self.name in SIGNALS else None


UnaryWord: TypeAlias = Literal["always", "eventually", "historically", "previously"]
BinaryWord: TypeAlias = Literal["until", "since"]
FUTURE = frozenset(("always", "eventually", "until"))


@dataclass(frozen=True)
class Temporal(Unary):
    """A formula at every, or at some, instant of a window after or before the present one."""

    word: UnaryWord
    window: TimeWindow

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        raise _beyond_one_instant(self.word, self.column)

    @override
    def infer(self, types: Types) -> Type | None:
        self.operand.expect(types, "bool")
        return "bool"


@dataclass(frozen=True)
class Chain(Binary):
    """`a until b`: a holds up to an instant at which b does; `a since b` looks back instead."""

    symbol: BinaryWord
    window: TimeWindow

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        raise _beyond_one_instant(self.symbol, self.column)

    @override
    def infer(self, types: Types) -> Type | None:
        self.left.expect(types, "bool")
        self.right.expect(types, "bool")
        return "bool"


EdgeWord: TypeAlias = Literal["starts", "ends"]
MeasureWord: TypeAlias = Literal["count", "mean", "rate", "value"]


@dataclass(frozen=True)
class Edge(Unary):
    """The instants at which a condition begins, or ceases, to be true."""

    word: EdgeWord

    @override
    def evaluate(self, scope: EvaluationScope) -> Plain:
        raise _beyond_one_instant(self.word, self.column)

    @override
    def infer(self, types: Types) -> Type | None:
        self.operand.expect(types, "bool")
        return "bool"


@dataclass(frozen=True)
class Measure(SyntaxNode):
    """A value out of what was so far: how often an edge was there, the mean of a number, ...

    Attributes:
        operand: What is measured; None for a count.
        edge: What is counted, or at the last of which the value is taken.
        window: Before the present instant.
    """

    word: MeasureWord
    operand: SyntaxNode | None
    edge: Edge | None
    window: TimeWindow

    @property
    @override
    def parts(self) -> tuple[SyntaxNode, ...]:
        return tuple(one for one in (self.operand, self.edge) if one is not None)

    @cached_property
    def key(self) -> str:
        """What its value is known by."""
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


Timed: TypeAlias = Temporal | Chain | Edge | Measure
"""The parts that speak of other instants than the present one."""


def _beyond_one_instant(word: str, column: int) -> ExpressionError:
    return ExpressionError(f"'{word}' speaks of more than one instant", column)
