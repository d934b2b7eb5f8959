"""The parts of an expression that have the same value in every run, and what goes wrong in them."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping

from bt_mission.language.expressions import syntax
from bt_mission.language.expressions.selection import Conditional
from bt_mission.language.expressions.values import (
    ExpressionError,
    Plain,
    Type,
    fits,
    mismatch,
    type_of,
)

_DIVIDES = frozenset(("/", "//", "%"))


def evaluate_constants(
    root: syntax.SyntaxNode,
    values: Mapping[str, Plain],
    is_constant: Callable[[syntax.Name], bool],
    wanted: Type | None = None,
) -> None:
    """Evaluate what can be evaluated before the run. Raises ExpressionError.

    `values` are those of the names that are constant. What `and` and `or` do not look at is left
    out. Where the whole expression is constant it must be of the wanted type.
    """
    scope = syntax.EvaluationScope(values, {}, random.Random(0))
    if _is_constant(root, scope, is_constant):
        value = root.evaluate(scope)
        if wanted is not None and not fits(type_of(value), wanted):
            raise mismatch(value, wanted, root.column)


def _is_constant(
    node: syntax.SyntaxNode,
    scope: syntax.EvaluationScope,
    is_constant: Callable[[syntax.Name], bool],
) -> bool:
    """Return whether a part is constant; if not, evaluate the largest parts in it that are."""
    if isinstance(node, syntax.Name):
        return is_constant(node)
    if isinstance(node, Conditional):
        # Of the two values only one is evaluated; which one, a constant condition tells.
        is_settled = _is_constant(node.condition, scope, is_constant)
        return is_settled and _is_constant(node.selected(scope), scope, is_constant)
    return _has_constant_parts(node, scope, is_constant)


def _has_constant_parts(
    node: syntax.SyntaxNode,
    scope: syntax.EvaluationScope,
    is_constant: Callable[[syntax.Name], bool],
) -> bool:
    constant = []
    for part in node.parts:
        if _is_constant(part, scope, is_constant):
            constant.append(part)
        if isinstance(node, syntax.Logic) and part is node.left and constant:
            left: bool = part.need(scope, "bool")
            if left == (node.symbol == "or"):
                return False
    if len(constant) == len(node.parts) and not (
        isinstance(node, syntax.FunctionCall) and node.draws
    ):
        return True
    for part in constant:
        value = part.evaluate(scope)
        divides = (
            isinstance(node, syntax.Arithmetic) and node.symbol in _DIVIDES and part is node.right
        )
        if divides and value == 0:
            raise ExpressionError("division by zero", node.column)
    return False
