"""Goals and requests against the fields of their type: constants, expressions and templates."""

from __future__ import annotations

import random
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_mission.core.diagnostics import MOST_FAULTS, Diagnostic
from bt_mission.core.yaml.document import Document
from bt_mission.language.checks.scope import Variables, expression_faults, located, template_faults
from bt_mission.language.expressions.expression import Expression, Late, Template, Text, Value
from bt_mission.language.expressions.values import WORDS, ExpressionError, LooseText, Type
from bt_mission.language.message_types import (
    SHORTHANDS,
    ListOf,
    MessageShape,
    Path,
    Scalar,
    Shape,
    TypeMismatch,
    Unknowable,
    conform,
)
from bt_mission.language.nodes.remedies import beside


def read_goal(
    document: Document,
    at: Path,
    values: Mapping[str, Value],
    shape: MessageShape,
    variables: Variables,
    modifiers: Collection[str] = (),
) -> tuple[Mapping[str, Any], list[Diagnostic]]:
    """Return a goal or request, which stands at a path, and everything in it that does not fit.

    What only the run can tell is None in it; where anything does not fit it is of no use.
    `modifiers` are the keys that may stand beside the goal.
    """
    reader = _GoalReader(document, at, variables, modifiers)
    found = conform(shape, values, reader.read, reader.report)
    return found, reader.faults


@dataclass
class _GoalReader:
    """Reads texts as their fields want them, and notes what is wrong."""

    document: Document
    at: Path
    variables: Variables
    modifiers: Collection[str] = ()
    faults: list[Diagnostic] = field(default_factory=list)

    def report(self, problem: TypeMismatch) -> None:
        if len(self.faults) >= MOST_FAULTS:
            return
        path, hint = (*self.at, *problem.path), problem.hint
        if problem.at_key and len(problem.path) == 1 and problem.path[0] in self.modifiers:
            hint = beside(str(problem.path[0]), str(self.at[-1]))
        fault = self.document.fault(path, problem.message, hint, key=problem.at_key)
        self.faults.append(fault)

    def read(self, path: Path, shape: Shape, text: Text | Late) -> Any:
        """Return the value that a text has in every run. Raises Unknowable where it varies."""
        assert isinstance(text, Text), "a loaded goal holds nothing that is resolved"
        if len(self.faults) >= MOST_FAULTS:
            raise Unknowable
        if isinstance(shape, Scalar) and shape.type == "text":
            return self.as_template((*self.at, *path), text.template)
        return self.as_expression((*self.at, *path), text.expression, shape)

    def as_template(self, path: Path, template: Template | ExpressionError) -> Any:
        if isinstance(template, ExpressionError):
            self.faults.append(located(self.document, path, template))
            raise Unknowable
        faults = list(template_faults(self.document, path, template, self.variables))
        self.faults += faults
        if faults or template.draws or not self.variables.fixes(template.names):
            raise Unknowable
        return self.value(path, template)

    def as_expression(
        self, path: Path, expression: Expression | ExpressionError, shape: Shape
    ) -> Any:
        words, wanted = _wanted(shape)
        if isinstance(expression, ExpressionError):
            message = expression.message
            if isinstance(expression, LooseText):
                message = f"expected {words} or an expression: {message}"
            offset = expression.column - 1
            fault = self.document.fault(path, message, expression.hint, offset=offset)
            self.faults.append(fault)
            raise Unknowable
        if expression.draws or not self.variables.fixes(expression.names):
            self.faults += expression_faults(
                self.document, path, expression, self.variables, wanted, expected=words
            )
            raise Unknowable
        return self.value(path, expression)

    def value(self, path: Path, text: Expression | Template) -> Any:
        try:
            return text.evaluate(self.variables.inputs, random.Random(0))
        except ExpressionError as error:
            self.faults.append(located(self.document, path, error))
            raise Unknowable from None


def _wanted(shape: Shape) -> tuple[str, Type | None]:
    """Return in words what a field takes, and the type an expression for it must have."""
    match shape:
        case Scalar():
            return f"{WORDS[shape.type]} ({shape.name})", shape.type
        case ListOf():
            return f"a list ({shape.name})", "list"
    if shape.name in SHORTHANDS:
        return SHORTHANDS[shape.name]
    return f"a mapping ({shape.name})", None
